"""A joint's friction or offset that changes at one moment of its runs.

A brake that lets go late, a belt that slips: an exponential from the beginning of the run imitates
it, and was told as warming up. When and in which of the fitted runs it is, the fit side says;
whether it is, the held-out side.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    BROKEN_SHARE,
    CLUSTERS,
    SLOPES,
    STEP_CLOSELY,
    STEP_EVERY,
    STEP_LEVEL,
    STEP_MARGIN,
)
from pa10d.diagnose.evidence.errors_of import doubt_of
from pa10d.diagnose.evidence.held_out import judge
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.own_part import own_part
from pa10d.diagnose.unknown.parts import rows_of, seconds_of
from pa10d.regression.per_joint import rms

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StepInTime:
    """Of a joint (0-based), at so many seconds of these runs (empty: of every run). share, rms N·m:
    of its error on the held-out side that is gone with it; left: N·m that is not."""

    joint: int
    seconds: float
    runs: tuple[str, ...]
    share: float
    rms: float
    left: float
    p_value: float


@dataclass(frozen=True)
class _Step:
    """What is tried: other friction and offset before that moment of those runs, or after it."""

    seconds: float
    runs: tuple[str, ...]
    before: bool

    def columns(self, side: Side, joint: int, motion: tuple[Array, Array], some: bool) -> Array:
        """(m_j, 3) on one side. some: where those runs are some of it, and not all."""
        t, columns = motion
        there = (t < self.seconds) == self.before
        return columns * (there * rows_of(side, joint, self.runs) if some else there)[:, None]


def steps_in_time(state: SearchState, joints: Sequence[int]) -> list[StepInTime]:
    """Those of these joints that have one."""
    found = (_of(state, joint) for joint in joints)
    return [one for one in found if one is not None]


def _of(state: SearchState, joint: int) -> StepInTime | None:
    train, held = _motion(state.train, joint), _motion(state.held, joint)
    last = min(t.max(initial=0.0) for t, _ in (train, held)) - STEP_MARGIN
    names = tuple(dict.fromkeys(run.name for run in state.train.runs))
    coarse = list(_steps(np.arange(STEP_MARGIN, last, STEP_EVERY), names))
    if not coarse:
        return None

    def gain(step: _Step) -> float:
        columns = step.columns(state.train, joint, train, some=True)
        part = own_part(state.fit, {joint: columns / state.fit.sigma[joint]})
        return 0.0 if part is None else part.gain

    about = max(coarse, key=gain)
    near = np.arange(about.seconds - STEP_EVERY, about.seconds + STEP_EVERY, STEP_CLOSELY)
    fine = [_Step(float(at), about.runs, about.before) for at in near]
    best = max(fine, key=gain)
    change = _foretold(state, joint, best, train, held)
    if change is None:
        return None
    residual = state.held_residual()
    found = judge(state.held, residual, {joint: change}, doubt_of(state))
    p_value = min(1.0, found.p_value * (len(coarse) + len(fine)) * state.train.n)
    had, left = float(rms(residual[joint])), float(rms(residual[joint] - change))
    share = 1.0 - (left / had) ** 2 if had else 0.0
    lasting = found.cluster_t > CLUSTERS  # what a model lacks bends to it here and there alone
    fits = SLOPES[0] < found.slope < SLOPES[1]
    if p_value > STEP_LEVEL or not (lasting and fits and share > BROKEN_SHARE):
        return None
    steady = _foretold(state, joint, _Step(0.0, names, before=False), train, held)
    if steady is not None and left**2 > (1.0 - BROKEN_SHARE) * rms(residual[joint] - steady) ** 2:
        return None  # it is there from the beginning, or as good
    where = () if best.runs == names else (*best.runs, *(run.name for run in state.held.runs))
    return StepInTime(joint, best.seconds, where, share, float(np.sqrt(share)) * had, left, p_value)


def _foretold(
    state: SearchState,
    joint: int,
    step: _Step,
    train: tuple[Array, Array],
    held: tuple[Array, Array],
) -> Array | None:
    """(m_j,) N·m on the held-out side by what the fit side asks for."""
    weighted = step.columns(state.train, joint, train, some=True) / state.fit.sigma[joint]
    part = own_part(state.fit, {joint: weighted})
    if part is None:
        return None
    own = step.columns(state.held, joint, held, some=False)
    seen = state.fit.basis[joint].T @ weighted
    return state.change(state.fit, {joint: own}, seen, part.theta)[joint]


def _steps(times: Array, names: tuple[str, ...]) -> Iterator[_Step]:
    """In all runs, or in one alone, of which the others are like the end or like the beginning; a
    model without an offset is like one of them, too."""
    alone = [(name,) for name in names] if len(names) > 1 else []
    for at, runs, before in product(times.tolist(), [names, *alone], (True, False)):
        yield _Step(at, runs, before)


def _motion(side: Side, joint: int) -> tuple[Array, Array]:
    """(m_j,) s since its run began, and (m_j, 3): which way, how fast, and one."""
    rows = []
    for run, context in zip(side.runs, side.contexts, strict=True):
        speed = context.dq[:: run.lowpass.factor, joint]
        rows.append(np.column_stack([np.sign(speed), speed, np.ones(len(speed))]))
    return seconds_of(side, joint), side.gathered(rows, joint)
