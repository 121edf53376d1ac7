"""A smooth map where a user chose one: fitted in beside the model, and judged like any effect."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.words import from_one, rounded
from pa10d.diagnose.asked.stiffness import NormalEquations, stiffness
from pa10d.diagnose.constants import (
    ALIKE,
    LEAST_SLOPE,
    SMOOTH_LEVEL,
    SMOOTH_ROUNDS,
    SMOOTH_TAILS,
)
from pa10d.diagnose.evidence.errors_of import doubt_of
from pa10d.diagnose.evidence.held_out import Evidence, judge
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.timing import align
from pa10d.diagnose.search.versions import held_out, snapshot
from pa10d.effects.smooth_map import EXPLAINS_NOTHING, SMOOTHING, smooth_map
from pa10d.effects.variables import at_joint, values_of
from pa10d.judgement import in_band
from pa10d.measurement.recording import Recording
from pa10d.model import Term, TorqueModel
from pa10d.regression.spectrum import colour

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Smoothed:
    """The new version; whether the map removes anything that a fit has not seen; what to warn of;
    before, after: RMS N·m of the map's joint on held-out data."""

    model: TorqueModel
    helps: bool
    warnings: list[str]
    before: float
    after: float


def add_map(
    model: TorqueModel,
    joints: Sequence[int],
    over: Sequence[str],
    fit: Sequence[Recording],
    *,
    name: str,
    validate: Sequence[Recording] = (),
    progress: Callable[[float, str], None] | None = None,
) -> Smoothed:
    """A new version with a smooth map of one joint's torque (0-based) over one or two quantities,
    such as the ``depends_on`` of what a diagnosis could not explain."""
    joint, names = asked(model, joints, over)
    kind = smooth_map(names)
    say = progress or (lambda share, what: None)
    say(0.0, "filtering")
    model = in_band(model)
    train, held, _ = two_sides(model, fit, validate)
    say(0.2, "fitting the given model")
    state = SearchState.start(model, train, held)
    as_given = held_out(model, state)
    align(state)
    say(0.5, f"drawing the map over {' and '.join(names)}")
    shape = dict(kind.shape_over(ranges(train, joint, names), 1.0))
    term = Term(kind.id, (joint,), np.zeros(len(kind.coefficients)), shape, over=names)
    if any(other.label == term.label for other in state.terms):
        raise UserError(f"{term.label}: {model.name} has this map already; expected another one")
    _fit_in(state, term)
    evidence = _evidence(state)
    say(0.8, "standard errors")
    made = snapshot(model, state, len(state.terms), as_given)
    made = replace(made, name=name, change=f"added {term.label} ({EXPLAINS_NOTHING})")
    before, after = float(evidence.before[joint]), float(evidence.after[joint])
    warnings = _warnings(term.label, joint, " and ".join(names), evidence)
    say(1.0, "done")
    return Smoothed(made, not warnings, warnings, before, after)


def asked(
    model: TorqueModel, joints: Sequence[int], over: Sequence[str]
) -> tuple[int, tuple[str, ...]]:
    """The joint (0-based) and the full names of the quantities."""
    n = model.robot.n
    if len(joints) != 1 or not 0 <= joints[0] < n:
        named = ", ".join(str(j + 1) for j in joints) or "none"
        raise UserError(f"smooth_map: joint {named}: expected one joint of {from_one(n)}")
    names = tuple(at_joint(name, joints[0], n) for name in over)
    if not 1 <= len(names) <= 2 or len(set(names)) < len(names):
        raise UserError(
            f"smooth_map: over {', '.join(names) or 'nothing'}: expected one or two different "
            "quantities, such as q,dq"
        )
    return joints[0], names


def ranges(side: Side, joint: int, names: Sequence[str]) -> dict[str, tuple[float, float]]:
    """name -> from where to where the quantity goes in the samples of the joint's equation."""
    out = {}
    for name in names:
        values = np.concatenate(
            [
                values_of(context, name)[:: run.lowpass.factor][keep[:, joint]]
                for run, context, keep in zip(side.runs, side.contexts, side.keep, strict=True)
            ]
        )
        low, high = np.quantile(values, [SMOOTH_TAILS, 1.0 - SMOOTH_TAILS])
        if not high > low:
            raise UserError(f"smooth_map: {name} does not change in these runs; expected motion")
        out[name] = (float(low), float(high))
    return out


def _fit_in(state: SearchState, term: Term) -> None:
    """As the last term of the state, as stiff as it is most likely to be.

    Twice: how noisy each joint is, and how alike its samples are, shows only once the map has
    taken away what is no noise.
    """
    state.push(
        replace(term, shape={**term.shape, SMOOTHING: _smoothing(state, state.fit, term, ALIKE)})
    )
    state.refit()
    for _ in range(SMOOTH_ROUNDS):
        rest = state.fit.without(state.place(len(state.terms) - 1))
        joint = term.joints[0]
        alike = max(ALIKE, _alike(state.train, joint, state.fit.residual[joint]))
        shape = {**term.shape, SMOOTHING: _smoothing(state, rest, term, alike)}
        state.replace_term(len(state.terms) - 1, replace(state.terms[-1], shape=shape))
        state.refit()
        if any(one.effect.uses_model for one in state.terms):
            state.relook()
            state.refit()


def _smoothing(state: SearchState, fit: LeastSquares, term: Term, alike: float) -> float:
    """1/(N·m)², of a term beside a fit that does not have it."""
    shape = {**term.shape, SMOOTHING: 1.0}
    columns = state.train.columns(term.effect, term.joints, [shape])
    seen = sum(fit.basis[j].T @ (c / fit.sigma[j]) for j, c in columns.items())
    width = len(term.coefficients)
    gram, rhs, power, rows = np.zeros((width, width)), np.zeros(width), 0.0, 0
    for j, basis in fit.basis.items():
        own = -basis @ seen
        if j in columns:
            own = own + columns[j] / fit.sigma[j]
        gram, rhs = gram + own.T @ own, rhs + own.T @ fit.residual[j]
        power, rows = power + float(fit.residual[j] @ fit.residual[j]), rows + len(own)
    root = term.effect.penalty(shape)
    assert root is not None
    found = stiffness(NormalEquations(gram, rhs, power, rows, root.T @ root), alike)
    return found.ratio / found.variance


def _alike(side: Side, joint: int, residual: Array) -> float:
    """How many samples of a residual (m_j,) are worth one independent one."""
    gamma = colour(side.stretches(joint, residual), side.runs[0].rate)
    return float((2.0 * gamma.sum() - gamma[0]) / gamma[0])


def _evidence(state: SearchState) -> Evidence:
    """What the last term changes on data that the fit has not seen."""
    index = len(state.terms) - 1
    rest, term = state.fit.without(state.place(index)), state.terms[index]
    train, held = state.blocks[index]
    seen = np.asarray(sum(rest.basis[j].T @ (c / rest.sigma[j]) for j, c in train.items()))
    change = state.change(rest, held, seen, term.coefficients)
    doubt = doubt_of(state, rest, state.fit.residual)
    return judge(state.held, state.held_residual(rest), change, doubt)


def _warnings(label: str, joint: int, quantities: str, found: Evidence) -> list[str]:
    out = []
    if found.p_value > SMOOTH_LEVEL or found.slope < LEAST_SLOPE or found.gain <= 0:
        out.append(
            f"{label}: no significant gain on held-out data (p = {found.p_value:.2g}, joint "
            f"{joint + 1} from {rounded(found.before[joint], 3)} to "
            f"{rounded(found.after[joint], 3)} N·m): what is left does not "
            f"depend on {quantities}, or too little was seen of it"
        )
    if found.worse:
        worse = ", ".join(str(j + 1) for j in found.worse)
        out.append(f"{label}: the error of joint {worse} rises on held-out data")
    return out
