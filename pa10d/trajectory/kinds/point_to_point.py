"""Moves between poses, with pauses."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from pa10d.common.errors import UserError
from pa10d.trajectory.kinds.base import Angle, Array, Count, Kind, Share
from pa10d.trajectory.motions import Drawing, move_time
from pa10d.trajectory.plan import Plan, Segment, joined
from pa10d.trajectory.poses import Surroundings
from pa10d.trajectory.ways import way_is_free

TRIES = 60


class PointToPoint(Kind):
    """All chosen joints move together from pose to pose and rest in each."""

    kind: ClassVar[str] = "point_to_point"
    title: ClassVar[str] = (
        "Moves between poses with pauses: many poses, both directions, standstill"
    )

    poses: list[list[Angle]] | None = Field(
        min_length=1,
        default=None,
        description="rad, one row per pose; drawn at random where absent",
    )
    count: Count = Field(default=8, description="how many random poses")
    speed: Share = Field(default=0.7, description="share of the speed limits")
    share: Share = Field(default=0.7, description="share of each joint's range for random poses")
    pause: Annotated[float, Field(ge=0, le=60)] = Field(
        default=1.0, description="s at rest in each pose"
    )

    def build(self, around: Surroundings) -> Plan:
        """One segment per move, so that each pose can be looked at."""
        joints, home = self.chosen(around), self.home(around)
        poses = self._given(around, home) if self.poses else self._drawn(around, joints, home)
        segments = []
        for number, (here, there) in enumerate(zip([home, *poses], [*poses, home], strict=True)):
            drawing = Drawing(here)
            drawing.to(there, max(self._time(around, there - here), 0.1))
            arrived = drawing.time
            drawing.rest(max(self.pause, 0.1))
            last = number == len(poses)
            label = "" if last else f"pose {number + 1}"
            segments.append(Segment(drawing.knots(arrived, drawing.time), label))
        return joined(self.kind, joints, segments, around)

    def _time(self, around: Surroundings, span: Array) -> float:
        limits = around.limits
        return move_time(span, self.speed * limits.velocity, self.speed * limits.acceleration)

    def _given(self, around: Surroundings, home: Array) -> list[Array]:
        found = []
        for k, row in enumerate(self.poses or []):
            if len(row) != len(home):
                raise UserError(
                    f"poses: row {k + 1} has {len(row)} angles, expected {len(home)}, one per joint"
                )
            pose = np.array(row, dtype=float)
            found.append(around.within(pose, f"poses: row {k + 1}"))
        return found

    def _drawn(self, around: Surroundings, joints: list[int], home: Array) -> list[Array]:
        """Random poses whose straight ways are free as well."""
        rng = np.random.default_rng(self.seed)
        here = home
        poses: list[Array] = []
        for _ in range(self.count):
            for _ in range(TRIES):
                there = home.copy()
                there[joints] = around.random_pose(rng, self.share)[joints]
                if way_is_free(around, here, there) and (
                    len(poses) + 1 < self.count or way_is_free(around, there, home)
                ):
                    break
            else:
                raise UserError(
                    f"no free way from one random pose to the next in {TRIES} tries; expected a "
                    "smaller share of the ranges, or poses of your own"
                )
            poses.append(there)
            here = there
        return poses
