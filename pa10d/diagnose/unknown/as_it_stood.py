"""What one change alone would take of a frozen model's error, all else as it stood.

A frozen model may move as far as its own doubt allows. Where that doubt is wide, a payload of a
kilogram lies within it: bodies take it up, nothing is left to be named, and yet the model as it was
given is wrong by newton metres on every joint that carries it. Whether that is a change or what
the model's own data left open, no statistics of the new data can say; that a single change would
do, they can.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import joint_words, listed, percent, rounded
from pa10d.diagnose.constants import BROKEN_SHARE, MATERIAL_GAIN, MATERIAL_REST, MOVED_FAR
from pa10d.diagnose.regression.partial import bounded
from pa10d.diagnose.regression.state import SearchState, Suspects
from pa10d.dynamics import Robot
from pa10d.effects import Effect
from pa10d.model import Term, TorqueModel
from pa10d.model.term import in_units_of
from pa10d.model.unknowns import vector_of
from pa10d.regression.per_joint import PerJoint, rms

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OneChange:
    """place: the effect and its joints; named: as people call it, and its size; shares (n,) of each
    joint's squared error, as the model was given, that it takes on the held-out side when fitted to
    the fit side alone."""

    place: tuple[str, tuple[int, ...]]
    named: str
    shares: Array


def left_far_more(state: SearchState, moved: Array, now: Array, floor: Array) -> NDArray[np.bool_]:
    """(n,) joints of which a frozen model as it was given leaves more than it usually does, and far
    more than where it moves within its doubt, or more than usual even there and with all findings:
    ``moved`` without, ``now`` with them, (n,) N·m RMS held out. Not those that keep no more than
    noise; floor: (n,) N·m of it, nan where it is not known."""
    if state.usual is None or state.as_given is None:
        return np.zeros(state.held.n, dtype=bool)
    elsewhere = (state.as_given > MOVED_FAR * moved) | (now > state.usual)
    noise = state.as_given <= MATERIAL_REST * floor
    return np.asarray(elsewhere & (state.as_given > state.usual) & ~noise)


def stood_words(
    given: Array,
    left: Array,
    usual: Array,
    far: NDArray[np.bool_],
    changes: Mapping[int, OneChange],
) -> str:
    """Of all joints that ``left_far_more`` tells, (n,) N·m: as the model was given, where it moves,
    on its own runs; far (n,) mask; empty where there is none; changes: by joint."""
    if not far.any():
        return ""
    least = np.minimum(left, usual)
    worst = int(np.argmax(np.where(far, given / np.maximum(least, 1e-300), 0.0)))
    alike = [j for j in np.flatnonzero(far).tolist() if j != worst]
    where = (
        f"moving within its own doubt it leaves {rounded(left[worst], 3)}"
        if left[worst] <= usual[worst]
        else f"it leaves {rounded(usual[worst], 3)} on its own runs, and "
        f"{rounded(left[worst], 3)} moving within its own doubt,"
    )
    said = (
        f"as it was given the model leaves {rounded(given[worst], 3)} where {where} on "
        f"joint {worst + 1}" + (f" ({joint_words(alike)} alike)" if alike else "")
    )
    change = changes.get(worst)
    if change is not None:
        took = [j for j, other in changes.items() if other is change]
        said += (
            f"; {change.named} alone, all else as it was, takes {percent(change.shares[worst])} of "
            "it" + (f", and most of it on {joint_words(sorted(took))}" if len(took) > 1 else "")
        )
    return f"{said}; that it came, or that the model's own runs left it open, other runs can tell"


def alone_words(
    given: Array, changes: Mapping[int, OneChange], units: Sequence[str]
) -> dict[int, str]:
    """By joint: what its change takes of its error as the model was given, (n,) N·m, where that is
    most of it."""
    return {
        j: f"{change.named} alone takes {percent(change.shares[j])} of the {rounded(given[j], 3)} "
        f"{units[j]} that the model leaves there as it was given"
        for j, change in changes.items()
    }


@dataclass(frozen=True)
class _Tried:
    """after: joint -> (m_j,) N·m held out, of those where it acts."""

    place: tuple[str, tuple[int, ...]]
    named: str
    count: int
    after: PerJoint


@dataclass(frozen=True)
class Alone:
    """What each of several changes, fitted to the fit side alone, would leave of the held-out one,
    all else as it stood.

    left: joint -> (m_j,) N·m of the model as it was given; sigma (n,) N·m: weights of the joints
    """

    left: PerJoint
    sigma: Array
    tried: tuple[_Tried, ...]

    @classmethod
    def of(cls, state: SearchState, given: TorqueModel, suspects: Suspects) -> Alone:
        """suspects: those with a shape of their own are left out, for they bend to what a model
        lacks."""
        fitted, left = _as_given(state, given)
        tried = []
        for effect, joints in suspects:
            if not all(s.smoothing or s.optional for s in effect.shapes):
                continue
            shape = effect.starts(state.train.contexts[0], joints)[0]
            fit, held = (s.columns(effect, joints, [shape]) for s in (state.train, state.held))
            if any(len(c) and not np.all(np.isfinite(c)) for c in (*fit.values(), *held.values())):
                continue
            theta = _fitted(state, fitted, fit, effect, joints)
            term = Term(effect.id, tuple(joints), theta, dict(shape))
            named = f"{effect.named}{_sized(state.model.robot, term)}"
            after = {j: left[j] - c @ theta for j, c in held.items()}
            tried.append(_Tried((effect.id, tuple(joints)), named, len(theta), after))
        return cls(left, state.fit.sigma, tuple(tried))

    def one(self, on: int | None = None) -> OneChange | None:
        """The plainest of the changes that take nearly the most; None where none takes half of it.
        on: the joint whose error counts, and whose changes; None: all."""
        asked = [one for one in self.tried if on is None or one.place[1] == (on,)]
        sizes = [self._size(one.after, on) for one in asked]
        whole = self._size({}, on)
        least = min(sizes, default=whole)
        if least > (1.0 - BROKEN_SHARE) * whole:
            return None
        near = [k for k, size in enumerate(sizes) if size <= least + MATERIAL_GAIN * whole]
        best = asked[min(near, key=lambda k: (asked[k].count, sizes[k]))]
        shares = [
            1.0 - _power(best.after.get(j, r)) / max(_power(r), 1e-300)
            for j, r in self.left.items()
        ]
        return OneChange(best.place, best.named, np.array(shares))

    def on_their_own(self, asked: NDArray[np.bool_], usual: Array) -> dict[int, OneChange]:
        """By joint (0-based) of those asked for, (n,) mask: a change of that joint alone that takes
        most of its error, and three quarters of what is more than usual, (n,) N·m RMS of the
        model's own runs: that came since, if it is no more of what the model lacks that another
        motion shows."""
        told = {}
        for j in np.flatnonzero(asked).tolist():
            given = rms(self.left[j])
            if given <= MATERIAL_REST * usual[j]:
                continue
            change = self.one(on=j)
            came = 1.0 - (usual[j] / given) ** 2
            if change is not None and change.shares[j] >= (1.0 - MOVED_FAR**-2) * came:
                told[j] = change
        return told

    def _size(self, after: PerJoint, on: int | None) -> float:
        """Squared error of all joints or of one, each in units of its weight, per sample."""
        return sum(
            _power(after.get(j, r)) / len(r) / float(self.sigma[j]) ** 2
            for j, r in self.left.items()
            if len(r) and on in (None, j)
        )


def _power(left: Array) -> float:
    return float(left @ left)


def _as_given(state: SearchState, given: TorqueModel) -> tuple[PerJoint, PerJoint]:
    """Of either side, joint -> (m_j,) N·m that the model leaves as it was given."""
    beta = vector_of(given.h, given.terms)
    bare = state.bare(len(given.terms))
    out = []
    for which, side in enumerate((state.train, state.held)):
        matrix = bare.matrix(which)
        out.append({j: side.tau[j] - matrix[j] @ beta for j in range(side.n)})
    return out[0], out[1]


def _fitted(
    state: SearchState,
    left: PerJoint,
    columns: PerJoint,
    effect: Effect,
    joints: Sequence[int],
) -> Array:
    """Coefficients by which an effect takes most of an error, with what the model has of it in the
    range in which it can be: no friction falls below none."""
    sigma = state.fit.sigma
    rows = np.concatenate([c / sigma[j] for j, c in columns.items()])
    target = np.concatenate([left[j] / sigma[j] for j in columns])
    there = state.same_before(effect, joints)
    has = np.zeros(len(effect.coefficients)) if there is None else there.coefficients
    lower = np.array([c.lower for c in effect.coefficients]) - has
    upper = np.array([c.upper for c in effect.coefficients]) - has
    return bounded(rows.T @ rows, rows.T @ target, lower, upper)


def _sized(robot: Robot, term: Term) -> str:
    """`` (Fc about 2.5 N·m)``; empty where nothing comes out of it."""
    nothing = np.zeros((len(term.coefficients),) * 2)
    found = term.effect.values(term.coefficients, nothing, term.shape, {})
    told = [
        f"{name} about {rounded(value.value, 2)}{value.unit_after}"
        for name, value in in_units_of(robot, term, found).items()
        if name not in term.shape and value.determined
    ]
    return f" ({listed(told)})" if told else ""
