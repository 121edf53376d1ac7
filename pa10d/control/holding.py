"""What is thought to hold each joint as its brake opens, and what one weighs that it did not hold.

It tells that by the way it fell, and by how it fell before.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pa10d.control.carried import share_of
from pa10d.control.fall import Driven, FallWatch, Tried, Weighed
from pa10d.control.limits import ArmLimits
from pa10d.control.reference import Reference

Array = NDArray[np.float64]

FELL = 0.2  # of the following error that is allowed: such a joint was not held by what was thought


class HeldJoints(Protocol):
    """Of an arm under torque, (n,) each: where it is and shall be, and what is done about that."""

    limits: ArmLimits
    reference: Reference
    time: float

    @property
    def q(self) -> Array:
        """rad."""
        ...

    @property
    def dq(self) -> Array:
        """rad/s."""
        ...

    @property
    def rise(self) -> Array:
        """rad/s² by which each gets faster, either way."""
        ...

    @property
    def sent(self) -> Array:
        """N·m sent last."""
        ...

    @property
    def bears(self) -> bool:
        """Whether its control law takes what a joint weighs."""
        ...

    def bear(self, axis: int, torque: float) -> None:
        """So many N·m hold this joint besides; nothing for a law that takes none."""
        ...


class Holding:
    """Of an arm since it was powered; what its joints fell under before that counts, too."""

    def __init__(
        self, joints: HeldJoints, heaviest: Array | None, inertia: tuple[Array, Array] | None
    ) -> None:
        """heaviest, inertia: see ``Arm``."""
        limit = joints.limits.torque
        n = len(limit)
        self._joints = joints
        self._heaviest = limit if heaviest is None else np.minimum(heaviest, limit)
        self._inertia = inertia
        self.thought = np.zeros(n)  # N·m by all that is known, to hold where brakes opened last
        self._described = np.zeros(n)  # N·m by the description, there
        self._told = np.zeros((2, n))  # N·m told of each, and described where it was
        self._falls, self._tried = FallWatch(n), Tried(n)
        self.alone: int | None = None  # all others being in their brakes
        self.by_trial: tuple[int, Weighed] | None = None  # a joint whose brake ends its fall
        self._caught: dict[int, Weighed] = {}  # a joint that fell, and is borne by that
        self.fell: dict[int, Weighed] = {}  # joints that ended a power-up, as it weighed them

    def begin(self, thought: Array, described: Array) -> None:
        """N·m (n,) that are thought to hold the arm where it is, and that its description says."""
        self.thought, self._described = thought.copy(), described.copy()
        self._told = np.stack([self.thought, self._described])
        self._falls.restart()
        self.alone, self.by_trial, self._caught, self.fell = None, None, {}, {}

    def see(self) -> None:
        """One cycle of an arm that nobody has moved yet."""
        self._falls.see(self._joints.time, self._joints.q, self._joints.sent)

    def hold(self, axis: int, torque: float) -> None:
        """By so many N·m this joint is thought to be held from now on."""
        self.thought[axis] = torque
        self._joints.bear(axis, torque)

    def at_most(self, axis: int, torque: float) -> float:
        """As much of it as this joint may weigh, N·m."""
        most = float(self._heaviest[axis])
        return float(np.clip(torque, -most, most))

    def catch(self) -> None:
        """Of an arm whose brakes have opened, the joint that falls farthest is borne by what it is
        seen to weigh, once. Of others, which it takes along, nothing is believed."""
        axis, far = self._farthest()
        if self._caught or far < FELL or not self._joints.bears:
            return
        thought, most = float(self.thought[axis]), float(self._heaviest[axis])
        found = self._falls.weighed(axis, thought, most)
        if found is not None:
            self._joints.bear(axis, found.torque)
            self._caught[axis] = found

    def take_along(self, described: Array, weighed: int | None, braked: set[int]) -> None:
        """The arm has moved since joints were weighed, and one is ``weighed`` now: all in their
        brakes weigh as many times what is ``described`` here, (n,) N·m, as there. Where masses
        explain no such share, or what is described has changed its sign, or doubled, as much."""
        if weighed is not None:
            self._told[:, weighed] = self.thought[weighed], described[weighed]
        told, there = self._told
        share, masses = share_of(told, there)
        along = masses & (np.abs(described - there) <= np.abs(there)) | (told == there)
        held = np.where(along, share * described, told)
        for axis in braked:
            self.hold(axis, float(held[axis]))
        self._described = described

    def driven(self, axis: int) -> Driven | None:
        """By what this joint falls."""
        return self._falls.driven(axis)

    def by_this_fall(self, axis: int) -> Weighed | None:
        """What would have held this joint, by nothing but the way it falls now."""
        thought, most = float(self.thought[axis]), float(self._heaviest[axis])
        return self._falls.weighed(axis, thought, most, self._presumed(axis))

    def swinging(self, axis: int) -> tuple[Driven | None, Weighed | None]:
        """Both of one that goes away in turns."""
        joints = self._joints
        now = joints.time, float(joints.q[axis]), float(joints.sent[axis])
        place, most = float(joints.reference.q[axis]), float(self._heaviest[axis])
        return self._falls.swinging(axis, now, place, most, self._presumed(axis))

    def in_vain(self, axis: int) -> str:
        """With what this joint was to be held, for a URDF may say too little, or too much; and what
        it weighs, where that can be told from the way it fell."""
        in_units = self._joints.limits.in_units
        self.fell.update(self._caught)
        first, _ = self._farthest()  # what carries a joint takes it along, not the other way round
        taken_along = first < axis if self.alone is None else first != axis
        if taken_along and (found := self._weighed(first)) is not None:
            self.fell[first] = found
            phrase = in_units(first, found.phrase)
            return f"; joint {first + 1} has fallen farther and taken it along, and {phrase}"
        thought, sent = self.thought[axis] + 0.0, self._joints.sent[axis] + 0.0  # no -0
        said = f"; {thought:.2g} N·m was to hold it, {sent:.2g} N·m has not"
        said = in_units(axis, said)
        if (found := self._weighed(axis)) is not None:
            self.fell[axis] = found
            return f"{said}; {in_units(axis, found.phrase)}"
        others = [(j, one) for j, one in self._caught.items() if j != axis]
        told = [(j, in_units(j, one.phrase)) for j, one in others]
        return said + "".join(f"; joint {j + 1} fell, too, and {phrase}" for j, phrase in told)

    @property
    def blamed(self) -> int:
        """The joint, from 1, that was weighed last as it ended this power-up; 0: none."""
        return 1 + list(self.fell)[-1] if self.fell else 0

    def _farthest(self) -> tuple[int, float]:
        """The joint that falls: the one whose brake alone is open, or that is farthest from its
        place; and how far, of what it may be."""
        joints = self._joints
        far = np.abs(joints.q - joints.reference.q) / joints.limits.following_error
        axis = int(np.argmax(far)) if self.alone is None else self.alone
        return axis, float(far[axis])

    def _weighed(self, axis: int) -> Weighed | None:
        """This joint, by the way it fell, be it roughly, and by how it fell before."""
        if self.by_trial is not None and self.by_trial[0] == axis:
            return self.by_trial[1]
        alone, inertia, joints = self.alone is not None, self._presumed(axis), self._joints
        most, thought = float(self._heaviest[axis]), float(self.thought[axis])
        far, described = joints.q[axis] - joints.reference.q[axis], float(self._described[axis])
        way = self._falls.way(axis)
        back = way * float(far) < 0.0  # its servo throws it: what unwinds looks like any weight
        found = self._falls.weighed(axis, thought, most, None if back else inertia)
        if back:
            found = found or self._caught.get(axis)
        else:
            fell = self._falls.driven(axis)
            more = self._tried.again(axis, described, fell, found, alone, inertia)
            if more is not None:
                found = replace(more, torque=self.at_most(axis, more.torque))
            found = self._tried.same_way(axis, thought, described, found)
        found = self._tried.between(axis, self._falls.under(axis, thought), described, way, found)
        return found and replace(found, torque=self.at_most(axis, found.torque))

    def _presumed(self, axis: int) -> float | None:
        """kg·m² as this joint moves now."""
        alone = self.alone is not None
        return None if self._inertia is None else float(self._inertia[alone][axis])
