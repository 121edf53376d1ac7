"""Effects of which the fit saw no more than a tail: their size elsewhere is extrapolated.

Friction at low speed is largest where joints turn round, and there nothing is fitted or judged,
because the sign of friction is not known. A fit that saw fast reversals only can follow the foot of
such a curve to the last digit and still be wrong about its peak by any factor; standard errors do
not tell, because they believe in the law.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import rounded
from pa10d.diagnose.constants import SEEN_SHARE
from pa10d.model import Term, TorqueModel
from pa10d.model.names import AGAIN, told_apart
from pa10d.regression.equation import RunEquation
from pa10d.regression.winding import seen_by

Array = NDArray[np.float64]


def tails(model: TorqueModel, terms: Sequence[Term], runs: Sequence[RunEquation]) -> dict[str, str]:
    """Label -> a line, for each term whose largest torque in the fitted samples is a small share of
    what it claims where its joint turns round or rests. Not of what sensors do: a late torque is as
    late everywhere, however steep it is where a joint turns round."""
    terms = [term for term in terms if not term.effect.sensing]
    if not terms:
        return {}
    peaks = np.max([_peaks(model, terms, run) for run in runs], axis=0)
    lines = {
        term.label: _tail(model, term, seen, out)
        for term, (seen, out) in zip(terms, peaks, strict=True)
    }
    return {label: line for label, line in lines.items() if line is not None}


def with_open(model: TorqueModel, labels: Container[str]) -> TorqueModel:
    """The same model, how large these terms are left open: the fit saw their tails."""
    names = [
        term.named(coefficient.name) if term.label in labels else ""
        for term in model.terms
        for coefficient in term.effect.coefficients
    ]
    open_ = [one for one in told_apart(names) if one.removesuffix(AGAIN)]
    return replace(model, notes=model.notes.with_open(open_))


def _tail(model: TorqueModel, term: Term, seen: Array, left_out: Array) -> str | None:
    j = int(np.argmax(left_out))
    if seen[j] >= SEEN_SHARE * left_out[j]:
        return None
    unit = model.robot.torque_unit(j)
    told = f"up to {rounded(seen[j], 2)} {unit}"
    most = told if seen[j] > 1e-3 * left_out[j] else "next to nothing"
    return (
        f"{term.label}: only its tail was seen, {most} in the samples that are fitted; the "
        f"{rounded(left_out[j], 2)} {unit} that it claims where the joint turns round or rests are "
        f"extrapolated, whatever the standard errors say. "
        f"To see it: {term.effect.experiment.rstrip('.')}"
    )


def _peaks(model: TorqueModel, terms: Sequence[Term], run: RunEquation) -> Array:
    """(terms, 2, n) N·m: each term's largest torque in samples that are fitted, and in those that
    are not because the joint turns round or rests."""
    seen = seen_by(model, run)
    masks = np.stack([run.keep, run.inside[:, None] & ~run.keep])
    masks = np.repeat(masks, run.lowpass.factor, axis=1)[:, : len(run.context.t)]
    torques = np.stack([np.abs(term.torque(seen)) for term in terms])
    return np.asarray((torques[:, None] * masks).max(axis=2))
