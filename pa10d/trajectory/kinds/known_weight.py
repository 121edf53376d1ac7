"""Poses in which a weight at the last joint loads every joint, gone through slowly, to and fro.

The way back is the way there, backwards: each pose is passed twice at the same speed, once in each
direction. So whatever friction there is, as long as it only turns round with the direction, it
cancels from the torque that a weight asks for, on all joints at once.
"""

from __future__ import annotations

from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pa10d.common.errors import UserError
from pa10d.dynamics import inverse_dynamics
from pa10d.dynamics.carried import carrying
from pa10d.dynamics.robot import rigid_body
from pa10d.trajectory.kinds.base import Angle, Array, Count, Kind, Positive, Share
from pa10d.trajectory.plan import Plan, Segment, move
from pa10d.trajectory.poses import Surroundings
from pa10d.trajectory.ways import free_way

TRIES = 300
REACH = 0.75  # of the half range around its middle, that a pose may use
BLIND = 0.02  # of the most that the weight asks of any joint: what it asks less of, it cannot load
LEAST = 1e-3  # of a joint's largest squared load, for a logarithm


class KnownWeight(Kind):
    """All joints from pose to pose and back, so slowly that gravity is most of the torque.

    The same request is recorded without the weight and with it; ``mass`` and ``com`` are of the
    heaviest that will be hung, so that the arm can carry it in every pose.
    """

    kind: ClassVar[str] = "known_weight"
    title: ClassVar[str] = "To and fro through poses in which a weight loads every joint"

    mass: Positive = Field(default=1.0, description="kg of the heaviest weight")
    com: list[Angle] = Field(
        default=[0.0, 0.0, 0.1], min_length=3, max_length=3,
        description="m, its centre in the last joint's frame",
    )  # fmt: skip
    count: Count = Field(default=6, description="how many poses")
    speed: Share = Field(default=0.3, description="share of the limits of speed and acceleration")

    def build(self, around: Surroundings) -> Plan:
        """A segment for each move, there and back."""
        joints, home = self.chosen(around), self.home(around)
        loaded = Surroundings(carrying(around.robot, self.mass, np.array(self.com)), around.limits)
        drawn = self._drawn(loaded, home, joints)
        asked = self._asked(around, drawn)[:, joints]
        poses = drawn[_chosen(asked, self.count)]
        way = _way(loaded, _in_order(poses, home))
        there = list(pairwise(way))
        back = [(end, begin) for begin, end in reversed(there)]
        segments = [
            Segment(move(begin, end, around.limits, self.speed), label)
            for label, steps in (("there", there), ("back", back))
            for begin, end in steps
        ]
        blind = [joints[k] + 1 for k in np.flatnonzero(~_loaded(asked))]
        notes = tuple(
            f"joint {j}: at rest the weight asks nothing of it, whatever the pose" for j in blind
        )
        return Plan(self.kind, tuple(j + 1 for j in joints), tuple(segments), notes)

    def _drawn(self, around: Surroundings, home: Array, joints: list[int]) -> Array:
        """(m, n) poses that the loaded arm can hold and reach."""
        limits = around.room
        rng = np.random.default_rng(self.seed)
        drawn = np.tile(home, (TRIES, 1))
        turn = rng.uniform(-1, 1, (TRIES, len(joints)))
        drawn[:, joints] = limits.middle[joints] + REACH * limits.half[joints] * turn
        fine = drawn[around.allowed(drawn)]
        usable = np.array([pose for pose in fine if around.reachable(pose)])
        if len(usable) < self.count:
            raise UserError(
                f"known_weight: only {len(usable)} of {TRIES} random poses are free and light "
                f"enough with {self.mass:g} kg; expected at least {self.count}: a lighter weight, "
                "fewer poses, or less around the arm (environment)"
            )
        return usable

    def _asked(self, around: Surroundings, poses: Array) -> Array:
        """(m, n) N·m that the weight asks for at rest."""
        only = np.zeros((around.robot.n, 10))
        only[-1] = rigid_body(self.mass, self.com)
        zero = np.zeros_like(poses)
        return inverse_dynamics(around.robot, only, poses, zero, zero)


def _loaded(asked: Array) -> NDArray[np.bool_]:
    """(k,) joints that the weight can load at all."""
    most = np.abs(asked).max(axis=0)
    return np.asarray(most > BLIND * most.max())


def _chosen(asked: Array, count: int) -> list[int]:
    """Rows of ``asked`` (m, k) that load every joint, each as well as it can be: one after the
    other, the one that adds most to the product of the joints' mean squared loads."""
    seen = asked[:, _loaded(asked)] ** 2
    share = seen / seen.max(axis=0)
    rows: list[int] = []
    total = np.full(share.shape[1], LEAST)
    for _ in range(count):
        worth = np.log(total + share).sum(axis=1)
        worth[rows] = -np.inf
        rows.append(int(np.argmax(worth)))
        total = total + share[rows[-1]]
    return rows


def _in_order(poses: Array, home: Array) -> list[Array]:
    """Each next to the one before it, beginning near home: less to move."""
    left, way = list(range(len(poses))), []
    here = home
    while left:
        nearest = min(left, key=lambda k: float(np.abs(poses[k] - here).max()))
        left.remove(nearest)
        here = poses[nearest]
        way.append(here)
    return way


def _way(around: Surroundings, poses: list[Array]) -> list[Array]:
    """The poses with what has to be gone through between them."""
    way = poses[:1]
    for pose in poses[1:]:
        way += free_way(around, way[-1], pose)
    return way
