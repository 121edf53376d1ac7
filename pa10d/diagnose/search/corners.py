"""How sharply dry friction turns round, where identification does not know it well.

What builds up over a way looks, on fast motion, like a sign that is soft: the fit side pays for a
blunt corner with something else, and slow motion pays it back. A corner that is too soft, in turn,
leaves at low speed what looks like friction of another law. So a corner that may as well be sharp
moves to where the held-out side is best, among those that the fit side has no reason to refuse.
Friction below zero has no corner: viscous friction less a blunt sign rises as a drag does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    CORNER_ERRORS,
    CORNERS,
    LEAST_GAIN,
    LOOSE,
    MATERIAL_GAIN,
    MATERIAL_HARM,
    MATERIAL_REST,
)
from pa10d.diagnose.regression.clear_of_knocks import clear_of_knocks
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.refining import refine
from pa10d.model import TorqueModel
from pa10d.regression.layout import has_sign

Array = NDArray[np.float64]


def with_corners(state: SearchState) -> SearchState:
    """Loose corners of all joints as both sides have them together: then each is known as well as
    the two agree."""
    if state.frozen:
        return state
    for joint in range(state.train.n):
        index = loose_corner(state, joint)
        if index is not None:
            state = _with_corner(state, index)
    return state


def corners_anew(state: SearchState) -> SearchState:
    """All corners as both sides have them clear of knocks, once all columns pass another torque
    channel: beside the one before, or none, each made up for what that smeared."""
    (seen,) = clear_of_knocks(state)
    for index, term in enumerate(state.terms):
        over = term.effect.smoothed_over
        if not over or not has_sign(term, term.joints[0]):
            continue
        seen = _with_corner(seen, index)
        speed = seen.terms[index].shape[over]
        if speed != state.terms[index].shape[over]:
            state = turned(state, index, speed)
    return state


def _dry_friction(state: SearchState, joint: int) -> int | None:
    """The term of the joint's friction whose sign turns round over a corner."""
    for index, term in enumerate(state.terms):
        if term.joints == (joint,) and term.effect.smoothed_over and has_sign(term, joint):
            return index
    return None


def loose_corner(state: SearchState, joint: int) -> int | None:
    """The joint's Coulomb friction, if two of its corner's standard errors reach down to zero."""
    if (index := _dry_friction(state, joint)) is None:
        return None
    term = state.terms[index]
    over = term.effect.smoothed_over
    return index if LOOSE * term.shape_errors.get(over, np.inf) > term.shape[over] else None


def sharper_instead(state: SearchState, joints: tuple[int, ...], left: Array) -> SearchState | None:
    """With a sharper corner of the joint's dry friction, where that alone does what some other
    friction there does: the fit side asks for it as for a finding, and no more is left than with
    that, (n,) N·m held out. Identification sees what happens as a joint turns round, too, where a
    short way over which friction builds up looks like a soft corner; in steady motion that is
    missing at low speed. Of a model that was identified from faster motion that is no change.
    """
    if len(joints) != 1 or (index := _dry_friction(state, joints[0])) is None:
        return None
    (joint,), term = joints, state.terms[index]
    over = term.effect.smoothed_over
    was, had = term.shape[over], state.fit.rms()[joint]
    trials = {v: turned(state, index, v) for v in was * CORNERS if v < was}
    best = min(trials, key=lambda v: trials[v].fit.rms()[joint])
    found = trials[best]
    gain = len(state.train.tau[joint]) * (1.0 - (found.fit.rms()[joint] / had) ** 2)
    alike = rms(found.held_residual())[joint] <= (1.0 + MATERIAL_GAIN) * left[joint]
    turns = found.moving_rms()[joint] <= state.moving_rms()[joint]
    if not (gain >= LEAST_GAIN and alike and turns and _rubs(found, index)):
        return None
    sharp = replace(found.terms[index], shape_errors={**term.shape_errors, over: float(best)})
    found.problem = found.problem.with_term(index, sharp)
    return found


def as_unsure(
    state: SearchState, joints: tuple[int, ...], left: Array, floor: Array | None
) -> SearchState | None:
    """With the corner of the joint's dry friction elsewhere within its own error, where no more is
    left so than with some other friction there, and than noise, (n,) N·m held out: slow motion may
    know of a corner what fast motion does not, and what a number is unsure by is no finding.
    """
    if len(joints) != 1 or floor is None:
        return None
    (joint,) = joints
    if (index := _dry_friction(state, joint)) is None:
        return None
    term = state.terms[index]
    over = term.effect.smoothed_over
    was, error = term.shape[over], term.shape_errors.get(over, 0.0)
    speeds = [was + part * error for part in CORNER_ERRORS]
    trials = [turned(state, index, v) for v in speeds if error > 0.0 and v > 0.0]
    trials = [one for one in trials if _rubs(one, index)]
    best = min(trials, key=lambda one: rms(one.held_residual())[joint], default=None)
    most = np.minimum((1.0 + MATERIAL_GAIN) * left[joint], MATERIAL_REST * floor[joint])
    if best is None or not rms(best.held_residual())[joint] <= most:  # nor of noise nobody knows
        return None
    return best if best.moving_rms()[joint] <= state.moving_rms()[joint] else None


def sharpened(given: TorqueModel, state: SearchState) -> dict[int, tuple[float, float]]:
    """joint (0-based) -> speeds of the corner of its dry friction, as given and as it is now, where
    it has become sharper."""
    out = {}
    for was, now in zip(given.terms, state.terms, strict=False):
        over = was.effect.smoothed_over
        if over and was.joints == now.joints and now.shape[over] < was.shape[over]:
            out[was.joints[0]] = was.shape[over], now.shape[over]
    return out


def turned(state: SearchState, index: int, speed: float) -> SearchState:
    """A copy with the corner of a joint's dry friction at this speed, and with it those of all
    that rubs in the joint and turned round as it did."""
    trial, dry = state.copy(), state.terms[index]
    before = dry.shape[dry.effect.smoothed_over]
    for k, term in enumerate(state.terms):
        if term.joints != dry.joints:
            continue
        for one in term.effect.shapes:
            if one.smoothing and term.shape.get(one.name) == before:
                shape = term.shape | {one.name: max(speed, one.lower)}
                trial.replace_term(k, replace(trial.terms[k], shape=shape))
    trial.refit()
    return trial


def _with_corner(state: SearchState, index: int) -> SearchState:
    term = state.terms[index]
    over, joint = term.effect.smoothed_over, term.joints[0]
    was, asked = term.shape[over], _fitted(state, index)
    moved = {v: turned(state, index, v) for v in (asked, *was * CORNERS) if v != was}
    trials = {was: state} | {v: one for v, one in moved.items() if _rubs(one, index)}
    fit = {v: rms(one.train_residual())[joint] for v, one in trials.items()}
    held = {v: rms(one.held_residual())[joint] for v, one in trials.items()}
    least = (1.0 + MATERIAL_HARM) * min(fit.values())
    allowed = {v: held[v] for v in trials if fit[v] <= least or v == was}
    most = (1.0 + MATERIAL_HARM) * min(allowed.values())
    alike = [v for v, left in allowed.items() if left <= most]
    best = next((v for v in (asked, was) if v in alike), min(alike, key=allowed.__getitem__))
    if best == was == asked:
        return state
    apart = max(abs(v - best) for v in (asked, *alike))
    found = trials[best].copy()
    kept = replace(found.terms[index], shape_errors={**term.shape_errors, over: apart})
    found.problem = found.problem.with_term(index, kept)
    return found


def _rubs(state: SearchState, index: int) -> bool:
    """Not below zero: a fit knows no bounds."""
    return bool(np.all(state.terms[index].coefficients >= 0.0))


def _fitted(state: SearchState, index: int) -> float:
    """The corner that the fit side alone asks for."""
    trial = state.copy()
    refine(trial, len(trial.terms), index)
    term = trial.terms[index]
    return term.shape[term.effect.smoothed_over]
