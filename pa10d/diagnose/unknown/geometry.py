"""An arm that is not as its URDF says: errors of several joints, and one cause for them.

Bodies are fitted; lengths, axes and angles are believed. Where those are wrong no bodies fit all
joints, and what is left looks like a spring here and a contact there. So a joint's frame elsewhere,
and a ring that is not centred (0271), are tried as other parameters are, to first order, beside
zeros, gains and a tilted base, which contradict the bodies likewise; and findings that they can do
without are dropped or doubted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.words import listed
from pa10d.diagnose.constants import (
    BROKEN_SHARE,
    CLAIMED_SHARE,
    CLUSTERS,
    FARTHEST_AXIS,
    FARTHEST_ORIGIN,
    GEOMETRY_LEVEL,
    MATERIAL_GAIN,
    MATERIAL_REST,
    SLOPES,
    TELL_APART,
)
from pa10d.diagnose.evidence.errors_of import doubt_of
from pa10d.diagnose.evidence.held_out import fit_side_power, judge, rivalry
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.shapes import free_shapes
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState, Suspects
from pa10d.diagnose.unknown.own_part import OwnPart, beside, lasting, own_part
from pa10d.diagnose.unknown.structure import find_structure
from pa10d.dynamics import Freedom, Robot, freedoms
from pa10d.model import Term
from pa10d.regression.per_joint import PerJoint, rms

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FrameElsewhere:
    """What is otherwise with a joint, and by how much: by (3,) m in the frame of the link that
    carries it, the turn of its axis in rad, or (2,) rad that its angle reads wrong; axis (3,) as
    the URDF has it, in the joint's frame."""

    freedom: Freedom
    by: Array
    axis: Array

    @property
    def words(self) -> str:
        """``joint 3 sits about 27 mm from there, most of it along -z of the link before``."""
        joint = self.freedom.joint + 1
        if self.freedom.kind == "axis":
            size = float(np.linalg.norm(self.by))
            return (
                f"the axis of joint {joint} points about {size:.2g} rad elsewhere, mostly towards "
                f"{_way(np.cross(self.by, self.axis))} of its own frame"
            )
        if self.freedom.kind == "ring":
            size = float(np.linalg.norm(self.by))
            return (
                f"the angle of joint {joint} reads wrong by up to {size:.2g} rad, once a turn (a "
                "ring that is not centred)"
            )
        size = 1e3 * float(np.linalg.norm(self.by))
        return (
            f"joint {joint} sits about {size:.2g} mm elsewhere, mostly along {_way(self.by)} of "
            "the link that carries it"
        )


def _way(vector: Array) -> str:
    """``-z``: the axis that it lies along most."""
    most = int(np.argmax(np.abs(vector)))
    return ("-" if vector[most] < 0.0 else "+") + "xyz"[most]


@dataclass(frozen=True)
class OtherGeometry:
    """Of a joint (0-based): share of its squared error that is gone with a geometry other than the
    URDF's; rms: N·m of that; p_value: of all that was tried; misplaced: what is elsewhere."""

    joint: int
    share: float
    rms: float
    p_value: float
    misplaced: tuple[FrameElsewhere, ...]
    variables: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """What is elsewhere, the farthest first."""
        return listed([one.words for one in self.misplaced])


@dataclass(frozen=True)
class Account:
    """What a geometry takes of the held-out errors: change, joint -> (m_j,) N·m; left (n,) N·m RMS
    with it; helpers: gains, zeros and the like (effect id, joints) that it needs beside it; and
    helped (n,) N·m RMS with these alone, of which the geometry takes nothing."""

    misplaced: tuple[FrameElsewhere, ...]
    change: PerJoint
    left: Array
    p_value: float
    helpers: frozenset[tuple[str, tuple[int, ...]]]
    helped: Array


@dataclass(frozen=True)
class Geometry:
    """told: a line for each joint concerned; state: without findings that only stood in for it;
    as_well: findings (effect id, joints) that it would do without as well as with."""

    told: tuple[OtherGeometry, ...]
    state: SearchState
    as_well: tuple[tuple[str, tuple[int, ...]], ...] = ()
    words: str = ""


def other_geometry(state: SearchState, suspects: Suspects, given: int, floor: Array) -> Geometry:
    """Is what several joints keep, or what was named there, a geometry that is not the URDF's?

    suspects: what contradicts the bodies likewise; given: terms that the model had before; floor:
    (n,) N·m, nan where it is not known
    """
    bare = state.bare(given)
    keeps = set(np.flatnonzero(_rms(bare.held_residual()) > MATERIAL_REST * np.nan_to_num(floor)))
    named = {j for term in state.terms[given:] for j in term.joints}
    nothing = Geometry((), state)
    if len(keeps | named) < 2:
        return nothing
    asked = _Asked(state, suspects)
    rest, found = _without_stand_ins(state, asked, given)
    if found is None:
        return nothing
    dropped = [t for t in state.terms[given:] if t not in rest.terms]
    if dropped:
        error, beside = rest.held_residual(), state.held_residual()
        moved = {j: error[j] - beside[j] for j in error}
        _, lead = rivalry(state.held, error, found.change, moved)
        if lead <= TELL_APART and not (lead > -TELL_APART and _simpler(found, dropped)):
            places = tuple((t.effect_id, t.joints) for t in dropped) if lead > -TELL_APART else ()
            return Geometry((), state, places, listed([one.words for one in found.misplaced]))
    told = _told(rest, found, CLAIMED_SHARE if dropped else BROKEN_SHARE)
    return Geometry(told, rest) if told else nothing


def _without_stand_ins(
    state: SearchState, asked: _Asked, given: int
) -> tuple[SearchState, Account | None]:
    """Without findings that leave no more on their joints where the geometry may be another. One
    that needs their like beside it does not go without them."""
    rest, found = state, asked.of(state)
    helpers = frozenset() if found is None else found.helpers
    for index in reversed(range(given, len(state.terms))):
        trial, joints = rest.copy(), list(rest.terms[index].joints) or slice(None)
        trial.drop(index)
        trial.refit()
        alone = asked.of(trial)
        left = _rms(rest.held_residual()) if found is None else found.left
        if alone is None or not alone.helpers <= helpers:
            continue
        if np.all(alone.left[joints] <= (1.0 + MATERIAL_GAIN) * left[joints]):
            rest, found = trial, alone
    return rest, found


def _simpler(found: Account, dropped: Sequence[Term]) -> bool:
    """One cause of fewer numbers for what was named on several joints?"""
    spent = sum(
        len(t.coefficients) + sum(not s.smoothing for s in free_shapes(t.effect, t.shape))
        for t in dropped
    )
    numbers = sum(one.freedom.along.shape[1] for one in found.misplaced)
    return len({t.joints for t in dropped}) > 1 and numbers < spent


def _told(state: SearchState, found: Account, least: float) -> tuple[OtherGeometry, ...]:
    """A line for each joint of which it says more than a map of the motion; none where it does not
    say this share of one joint's squared error, and something of another's: most of it, unless it
    stands against findings that say less."""
    before = _rms(state.held_residual())
    gone = (found.helped**2 - found.left**2) / np.maximum(before, 1e-300) ** 2
    joints = [int(j) for j in np.flatnonzero(gone > CLAIMED_SHARE)]
    maps = {m.joint: m.share for m in find_structure(state)} if len(joints) > 1 else {}
    joints = [j for j in joints if gone[j] > maps.get(j, 0.0)]
    if len(joints) < 2 or max(gone[joints]) < least:
        return ()
    return tuple(
        OtherGeometry(
            j, float(gone[j]), float(np.sqrt(gone[j]) * before[j]), found.p_value, found.misplaced
        )
        for j in joints
    )


@dataclass(frozen=True, eq=False)
class _Tried:
    """A freedom of the geometry, or what is its rival (effect id, joints), with its columns,
    joint -> (m_j, k), of the fit side."""

    freedom: Freedom | None
    rival: tuple[str, tuple[int, ...]] | None
    columns: PerJoint
    held: Callable[[], PerJoint]


@dataclass
class _Asked:
    """What is tried of an arm, worked out once: other bodies change it by what bodies absorb."""

    like: SearchState
    suspects: Suspects
    tried: list[_Tried] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.tried = list(_all(self.like, self.suspects))

    def of(self, state: SearchState) -> Account | None:
        """The geometry that this state asks for, if that holds on the held-out side."""
        fit, taken, p_value = state.fit, [], 1.0
        for _ in range(state.train.n):
            parts = [(one, _part(fit, one)) for one in self.tried if one not in taken]
            best = _plainest([(one, part) for one, part in parts if part is not None])
            if best is None:
                break
            power = fit_side_power(state.train, fit.residual, best[1].change)
            chance = float(scipy.stats.chi2.sf(power, best[1].size)) * len(self.tried)
            if chance > GEOMETRY_LEVEL or not lasting(state.train, fit, best[1]):
                break
            if best[0].freedom is not None:
                p_value = min(p_value, chance)
            taken.append(best[0])
            fit = beside(fit, best[1])
        return _account(state, taken, p_value)


def _all(state: SearchState, suspects: Suspects) -> Iterator[_Tried]:
    train, held = state.train, state.held
    for one in freedoms(state.model.robot):
        yield _Tried(one, None, _columns(train, one), partial(_columns, held, one))
    for effect, joints in suspects:
        shapes = [effect.starts(train.contexts[0], joints)[0]]
        columns = train.columns(effect, joints, shapes)
        yield _Tried(
            None, (effect.id, joints), columns, partial(held.columns, effect, joints, shapes)
        )


def _columns(side: Side, freedom: Freedom) -> PerJoint:
    """joint -> (m_j, k) filtered N·m per m or rad."""
    raw = [
        run.filtered(freedom.torque(c.robot, c.rigid, (c.q, c.dq, c.ddq)))
        for run, c in zip(side.runs, side.contexts, strict=True)
    ]
    return {j: side.gathered([x[:, j] for x in raw], j) for j in range(side.n)}


def _part(fit: LeastSquares, one: _Tried) -> OwnPart | None:
    return own_part(fit, {j: c / fit.sigma[j] for j, c in one.columns.items()})


def _plainest(found: Sequence[tuple[_Tried, OwnPart]]) -> tuple[_Tried, OwnPart] | None:
    """Of those that take as much as any the one that spends least on it."""
    most = max((part.gain for _, part in found), default=0.0)
    near = [pair for pair in found if pair[1].gain > (1.0 - MATERIAL_GAIN) * most]
    return min(near, key=lambda p: (p[0].freedom is not None, p[1].size, -p[1].gain), default=None)


def _account(state: SearchState, taken: Sequence[_Tried], p_value: float) -> Account | None:
    """All of it together, on the held-out side."""
    if all(one.freedom is None for one in taken):
        return None
    together = _together(state, taken)
    if together is None:
        return None
    change, sizes = together
    residual = state.held_residual()
    evidence = judge(state.held, residual, change, doubt_of(state))
    fits = SLOPES[0] < evidence.slope < SLOPES[1] and evidence.cluster_t > CLUSTERS
    misplaced = [
        FrameElsewhere(
            one.freedom, one.freedom.along @ size, state.model.robot.axis[one.freedom.joint]
        )
        for one, size in zip(taken, sizes, strict=True)
        if one.freedom is not None
    ]
    if evidence.p_value > GEOMETRY_LEVEL or not fits or _absurd(state.model.robot, misplaced):
        return None
    rivals = [one for one in taken if one.freedom is None]
    alone = _together(state, rivals) if rivals else None
    return Account(
        tuple(misplaced),
        change,
        _rms_without(residual, change),
        p_value,
        frozenset(one.rival for one in rivals if one.rival is not None),
        _rms(residual) if alone is None else _rms_without(residual, alone[0]),
    )


def _together(state: SearchState, taken: Sequence[_Tried]) -> tuple[PerJoint, list[Array]] | None:
    """What all of these change on the held-out side, the model refitted around them, joint ->
    (m_j,) N·m; and the coefficients of each. None where the model absorbs them."""
    widths = [next(iter(one.columns.values())).shape[1] for one in taken]
    sigma, n = state.fit.sigma, state.train.n
    weighted = _side_by_side([one.columns for one in taken], widths, state.train.tau)
    weighted = {j: c / sigma[j] for j, c in weighted.items()}
    part = own_part(state.fit, weighted)
    if part is None:
        return None
    own = _side_by_side([one.held() for one in taken], widths, state.held.tau)
    seen = np.sum([state.fit.basis[j].T @ weighted[j] for j in range(n)], axis=0)
    change = state.change(state.fit, own, seen, part.theta)
    return change, np.split(part.theta, np.cumsum(widths)[:-1])


def _absurd(robot: Robot, misplaced: Sequence[FrameElsewhere]) -> bool:
    """Farther than anybody errs, or than a first order tells?"""
    reach = FARTHEST_ORIGIN * float(np.linalg.norm(robot.translation, axis=1).max())
    farthest = {"origin": reach, "axis": FARTHEST_AXIS, "ring": FARTHEST_AXIS}
    return any(np.linalg.norm(m.by) > farthest[m.freedom.kind] for m in misplaced)


def _side_by_side(
    parts: Sequence[PerJoint], widths: Sequence[int], tau: Sequence[Array]
) -> PerJoint:
    """Joint -> (m_j, all widths): zeros where a part has nothing."""
    return {
        j: np.column_stack([
            part[j] if j in part else np.zeros((len(t), width))
            for part, width in zip(parts, widths, strict=True)
        ])
        for j, t in enumerate(tau)
    }  # fmt: skip


def _rms_without(residual: PerJoint, change: PerJoint) -> Array:
    return _rms({j: r - change[j] for j, r in residual.items()})


def _rms(residual: PerJoint) -> Array:
    return np.array([rms(residual[j]) for j in sorted(residual)])
