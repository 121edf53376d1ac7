"""Readings with a dead band: what findings near zero torque, or at it, may only stand in for.

A map over a joint's torque does not see it well: it is drawn over what a model says that was fitted
to such readings, its friction less by as much, and behind the band's filter. So the law itself is
fitted, on all joints that ask for it, with bodies, friction and loads anew.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    AS_BEFORE,
    DEAD_BAND_ROUNDS,
    LEAST_GAIN,
    MAP_LEVEL,
    OUTDONE,
    SLOPES,
)
from pa10d.diagnose.evidence.errors_of import doubt_of
from pa10d.diagnose.evidence.held_out import judge
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.refining import refine
from pa10d.effects.dead_band import DeadBand
from pa10d.model import Term

Array = NDArray[np.float64]


Bands = dict[int, tuple[float, float]]
"""By joint (0-based): N·m up to which it reads nothing, and the share of its squared error held out
that is gone with all of them."""


def dead_bands(bare: SearchState, joints: Sequence[int], left: Array, floor: Array | None) -> Bands:
    """Of those of these joints on which dead bands of the readings leave less than findings do,
    where on one of them they leave so much less that those were imitations.

    bare: without what was found; left, floor: (n,) N·m held out that the findings leave, and of the
    noise. Who leaves hardly more than that is not asked.
    """
    least = np.zeros(bare.held.n) if floor is None else np.nan_to_num(floor)
    if not any(left[j] ** 2 > OUTDONE * least[j] ** 2 for j in joints):
        return {}
    found = with_dead_bands(bare)
    bands = found.terms[len(bare.terms) :]
    size = {t.joints[0]: -float(t.coefficients[0]) * t.shape["d"] for t in bands}
    before, now = rms(bare.held_residual()), rms(found.held_residual())
    surely = [j for j in joints if j in size and OUTDONE * now[j] ** 2 < left[j] ** 2]
    if not any(_holds(bare, found, j) for j in surely):
        return {}
    return {
        j: (size[j], float(1.0 - (now[j] / before[j]) ** 2))
        for j in joints
        if j in size and now[j] < left[j]
    }


def with_dead_bands(bare: SearchState) -> SearchState:
    """A copy with dead bands on all joints that ask for one, settled."""
    found, first = bare.copy(), len(bare.terms)
    for joint in range(bare.train.n):
        if joint not in bare.held.silent:
            found = _with_one(found, joint)
    before = found.fit.rms()
    for _ in range(DEAD_BAND_ROUNDS if len(found.terms) > first else 0):
        found.relook()
        found.refit()
        for index in range(first, len(found.terms)):
            refine(found, first, index)
        after = found.fit.rms()
        if np.sum(np.log(before / after)) < AS_BEFORE:
            break
        before = after
    return found


def _with_one(state: SearchState, joint: int) -> SearchState:
    kind = DeadBand()
    trials = []
    for shape in kind.starts(state.train.contexts[0], (joint,)):
        trial = state.copy()
        trial.push(Term(kind.id, (joint,), np.zeros(1), dict(shape)))
        trial.refit()
        if trial.terms[-1].coefficients[0] < 0.0:
            trials.append(trial)
    best = min(trials, key=lambda trial: trial.fit.rms()[joint], default=state)
    taken = 1.0 - (best.fit.rms()[joint] / state.fit.rms()[joint]) ** 2
    return best if taken * len(state.train.tau[joint]) > LEAST_GAIN else state


def _holds(bare: SearchState, found: SearchState, joint: int) -> bool:
    """Is what they change on a joint there held out, in about its size?"""
    before, after = bare.held_residual(), found.held_residual()
    evidence = judge(bare.held, before, {joint: before[joint] - after[joint]}, doubt_of(bare))
    fits = SLOPES[0] < evidence.slope < SLOPES[1]
    return bool(fits and evidence.p_value * bare.held.n < MAP_LEVEL)
