"""What no effect explains, joint by joint, asked in the order of what can be named best.

What fitted runs contradict each other in; a map of the motion; of a torque as it is read; a step in
time; friction that is other held out; a cause that several joints have in common; a line in time;
what swings on; what several quantities of the motion foretell together; and last that it comes
again, follows reversals, or is simply too large.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.diagnose.constants import CARRIED_FARTHER, COMES_AGAIN_LEVEL, MATERIAL_REST
from pa10d.diagnose.evidence.errors_of import (
    carried_farther,
    honest_covariance,
    moved_by_doubt,
    moved_by_shapes,
)
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.between_runs import Apart
from pa10d.diagnose.unknown.claims import (
    Unexplained,
    Unnamed,
    comes_again,
    doubtful,
    material,
    unnamed,
)
from pa10d.diagnose.unknown.common_cause import in_common
from pa10d.diagnose.unknown.foretold import foretold
from pa10d.diagnose.unknown.geometry import OtherGeometry
from pa10d.diagnose.unknown.goes_with import GoesWith, goes_with
from pa10d.diagnose.unknown.humming import hums
from pa10d.diagnose.unknown.ringing import rings
from pa10d.diagnose.unknown.rubbing import OtherFriction, other_friction
from pa10d.diagnose.unknown.stepping import steps_in_time
from pa10d.diagnose.unknown.structure import (
    Structure,
    find_readings,
    find_structure,
    swaying_gains,
)
from pa10d.judgement import Judgement, RunResidual, reversing, turning
from pa10d.judgement.repeatable import Repeatable

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LeftOver:
    """unexplained: what is claimed; slight: maps that are too little for a claim; gains: by joint,
    such as sway and would explain more than what is claimed there; doubt (n,) N·m: what the
    uncertainty of the model's own coefficients may leave; undetermined: joints of which the fitted
    runs leave open as much as they keep, for the held-out side's motion, and how many times the
    floor they keep on the fitted runs themselves; beside: by joint, whose
    rest its own, of which nothing else is said, goes with."""

    unexplained: tuple[Unexplained, ...]
    slight: tuple[Structure, ...]
    gains: dict[int, Structure]
    doubt: Array
    undetermined: dict[int, float]
    beside: dict[int, GoesWith]


def left_over(
    state: SearchState,
    seen: Sequence[RunResidual],
    left: Judgement,
    again: Sequence[Repeatable | None],
    searched: bool,
    apart: Sequence[Apart | OtherGeometry] = (),
    given: int = 0,
    bent: Sequence[Unnamed] = (),
) -> LeftOver:
    """seen: the held-out side as the model with all findings sees it; left: its errors there;
    again: what comes again of them; searched: more than one suspicion was looked for; apart: what
    fitted runs contradict each other in, or lengths and axes that are not the URDF's; given: terms
    that the model had before; bent: what laws take at the end of what their shape may be."""
    maps, slight = material(left, find_structure(state) if searched else [])
    laws = {one.joint: one.share for one in bent}
    maps = [m for m in maps if m.share >= laws.get(m.joint, 0.0)]
    far = _farther(state, left, COMES_AGAIN_LEVEL / state.held.n, given)
    apart = [one for one in _more_than_maps(apart, maps) if not _undetermined(one, far)]
    contradicted = {one.joint for one in apart}
    maps = [m for m in maps if m.joint not in contradicted]
    slight = [m for m in slight if m.joint not in contradicted]
    open_ = unsaid(left, [*apart, *maps, *slight])
    open_ = [j for j in open_ if searched and j not in state.held.silent]
    read = _readings(state, left, maps, open_) if searched else {}
    stepped = _steps(state, [*apart, *maps, *read.values()], open_) if searched else {}
    said = [*apart, *maps, *read.values(), *stepped.values()]
    rubs = _other_friction(state, said, open_, far) if searched else {}
    stepped = {j: one for j, one in stepped.items() if j not in rubs}
    other = {**stepped, **rubs}
    read = {j: one for j, one in read.items() if j not in other}
    apart = [one for one in apart if one.joint not in other]
    maps = [m for m in maps if m.joint not in {**read, **other}]
    slight = [m for m in slight if m.joint not in other]
    open_ = [j for j in open_ if j not in {**read, **other}]
    moved = {j for j, one in enumerate(again) if one is not None and comes_again(one, len(again))}
    level = COMES_AGAIN_LEVEL / state.held.n
    doubt = doubtful(left, state.fit.rms(), moved_by_doubt(state, level))
    doubt, open_ = np.maximum(doubt, far), [j for j in open_ if not far[j]]
    together = [Unnamed.of_common(one) for one in in_common(state, open_)]
    open_ = [j for j in open_ if j not in {one.joint for one in together}]
    humming = {hum.joint: Unnamed.of_hum(hum) for hum in hums(state, sorted({*open_} - moved))}
    open_ = [j for j in open_ if j not in humming]
    told: list[Unexplained] = [*apart, *maps, *read.values(), *stepped.values(), *rubs.values()]
    told += together
    without = unsaid(left, [*told, *humming.values()])
    drawn = [one for one in bent if one.joint in without and not far[one.joint]]
    open_ = [j for j in open_ if j not in {one.joint for one in drawn}]
    ringing = {ring.joint: Unnamed.of_ring(ring) for ring in rings(state, open_)}
    undetermined = {j: _on_fit_side(state, left, j) for j in map(int, np.flatnonzero(far))}
    fitted = [j for j, ratio in undetermined.items() if ratio > MATERIAL_REST and j in without]
    asked = [j for j in open_ if j not in ringing]
    foreseen = [one.unnamed() for one in foretold(state, asked, fitted)]
    named = [*told, *humming.values(), *drawn, *ringing.values(), *foreseen]
    rest = unnamed(
        left, again, named, doubt, searched, turning(seen), reversing(seen), state.held.silent
    )
    gains = swaying_gains(state, {one.joint: one.share for one in told})
    rest_of = [j for j in unsaid(left, [*named, *slight]) if searched and j in open_]
    beside = goes_with(state, rest_of, [one.joint for one in named])
    return LeftOver((*named, *rest), tuple(slight), gains, doubt, undetermined, beside)


def _more_than_maps(
    apart: Sequence[Apart | OtherGeometry], maps: Sequence[Structure]
) -> list[Apart | OtherGeometry]:
    """Those that say more of their joint than its map does: what a model lacks looks like a change
    between runs that move differently."""
    shares = {m.joint: m.share for m in maps}
    return [one for one in apart if one.share > shares.get(one.joint, 0.0)]


def _undetermined(one: Apart | OtherGeometry, far: Array) -> bool:
    """Held-out runs that ask for what the fitted ones leave open contradict nobody."""
    return isinstance(one, Apart) and one.held_out and bool(far[one.joint])


def _farther(state: SearchState, left: Judgement, level: float, given: int) -> Array:
    """(n,) N·m: what all that is known of the doubt of coefficients, and of the shapes of what was
    found, may leave of joints that the held-out side asks for what the fitted runs do not
    determine, where that is as much as they keep; zero of all others."""
    if state.frozen or not unsaid(left, ()):
        return np.zeros(state.held.n)
    covariance, shapes = honest_covariance(state), moved_by_shapes(state, given)
    most = scipy.stats.norm.isf(0.5 * level) * shapes[1]
    moved = np.hypot(moved_by_doubt(state, level, covariance), most)
    doubt = doubtful(left, state.fit.rms(), moved)
    far = carried_farther(state, covariance, shapes) > CARRIED_FARTHER
    return np.where(far & (doubt > left.rms), doubt, 0.0)


def _on_fit_side(state: SearchState, left: Judgement, joint: int) -> float:
    """Times the noise floor that it keeps on the runs that the model was fitted to."""
    return float(state.fit.rms()[joint] / left.floor.values[joint])


def unsaid(left: Judgement, said: Sequence[Unexplained]) -> list[int]:
    """Joints that keep more than noise, as far as that is known, and of which nothing is said."""
    named = {s.joint for s in said}
    return [j for j, ratio in enumerate(left.ratio) if j not in named and not ratio < MATERIAL_REST]


def _steps(
    state: SearchState, told: Sequence[Unexplained], open_: Sequence[int]
) -> dict[int, Unnamed]:
    """By joint: a change at one moment, where that says more than what else is said."""
    shares = {one.joint: one.share for one in told}
    found = steps_in_time(state, sorted({*open_, *shares}))
    worth = [s for s in found if s.share > shares.get(s.joint, 0.0)]
    return {s.joint: Unnamed.of_step(s) for s in worth}


def _other_friction(
    state: SearchState, told: Sequence[Unexplained], open_: Sequence[int], far: Array
) -> dict[int, OtherFriction]:
    """By joint: friction that is other held out, where that says more than what else is said, and
    the fitted runs do not leave it open."""
    shares = {one.joint: one.share for one in told}
    joints = [j for j in sorted({*open_, *shares}) if not far[j]]
    return {
        one.joint: one
        for one in other_friction(state, joints)
        if one.share > shares.get(one.joint, 0.0)
    }


def _readings(
    state: SearchState, left: Judgement, maps: Sequence[Structure], open_: Sequence[int]
) -> dict[int, Unnamed]:
    """By joint: what its torque's reading depends on, where that says more than a map of motion."""
    shares = {m.joint: m.share for m in maps}
    found = find_readings(state, sorted({*open_, *shares}))
    worth, _ = material(left, [m for m in found if m.share > shares.get(m.joint, 0.0)])
    return {
        m.joint: Unnamed(m.joint, m.share, m.rms, m.p_value, "reading", m.variables) for m in worth
    }
