"""What to keep in mind of a model that has smooth maps: they know only where they have been."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.effects.smooth_map import EXPLAINS_NOTHING
from pa10d.judgement.residuals import RunResidual
from pa10d.model import Term, TorqueModel

WORTH_SAYING = 0.01  # share of a run outside a map's range


def map_warnings(model: TorqueModel, residuals: Sequence[RunResidual]) -> list[str]:
    """One line per map, and per run that leaves its range."""
    out = []
    for term in model.terms:
        if not term.over:
            continue
        out.append(f"{term.label} {EXPLAINS_NOTHING}")
        for run in residuals:
            share = outside(term, run)
            if share > WORTH_SAYING:
                out.append(
                    f"run {run.name}: {share:.0%} of it lies outside the range that {term.label} "
                    "was fitted on; there it is held at its edge"
                )
    return out


def outside(term: Term, run: RunResidual) -> float:
    """Share of the samples that count of the term's joint that lie beyond what it was fitted on."""
    beyond = term.effect.outside(run.seen, term.shape)
    if beyond is None:
        return 0.0
    return float(np.mean(run.decimated(beyond.astype(float))[run.counts[:, term.joints[0]]]))
