"""Constant speeds from slow to fast, both directions: the friction map of a joint."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field

from pa10d.common.errors import UserError
from pa10d.trajectory.kinds.base import Array, Count, Kind, Positive, Share
from pa10d.trajectory.kinds.strokes import fastest, to_and_fro
from pa10d.trajectory.plan import Plan, Segment, joined
from pa10d.trajectory.poses import Surroundings

SLOWEST = 0.005  # of the fastest speed
STEADY = 0.4  # s at constant speed at least


class VelocitySweep(Kind):
    """One joint after the other, at several constant speeds to and fro."""

    kind: ClassVar[str] = "velocity_sweep"
    title: ClassVar[str] = "Constant speeds, slow to fast, both directions: the friction map"

    speeds: list[Positive] | None = Field(
        min_length=1, default=None, description="rad/s; spread evenly where absent"
    )
    count: Count = Field(default=8, description="how many speeds")
    speed: Share = Field(
        default=0.8, description="share of the speed limit that the fastest one takes"
    )
    travel: Share = Field(default=0.8, description="share of the free range around the pose")
    longest: Positive = Field(default=3.0, description="s at one speed in one direction, at most")

    def build(self, around: Surroundings) -> Plan:
        """Two segments per speed and joint."""
        joints, pose = self.chosen(around), self.home(around)
        segments: list[Segment] = []
        for j in joints:
            lower, upper = around.free_range(pose, j)
            cut = 0.5 * (1 - self.travel) * (upper - lower)
            span = (lower + cut, upper - cut)
            for speed in self._speeds(around, j, span):
                segments += to_and_fro(
                    pose, j, span, speed, self.longest, around.limits.acceleration[j],
                    f"joint {j + 1}",
                )  # fmt: skip
        return joined(self.kind, joints, segments, around)

    def _speeds(self, around: Surroundings, j: int, span: tuple[float, float]) -> Array:
        limit = around.limits.velocity[j]
        top = fastest(span, self.speed * limit, around.limits.acceleration[j], STEADY)
        if self.speeds is None:
            return np.geomspace(SLOWEST * top, top, self.count)
        possible = fastest(span, limit, around.limits.acceleration[j], STEADY)
        for speed in self.speeds:
            if speed > possible:
                raise UserError(
                    f"joint {j + 1}: {speed:g} rad/s cannot be held for {STEADY:g} s within "
                    f"{span[0]:.2f} … {span[1]:.2f} rad; expected at most {possible:.3g} rad/s"
                )
        return np.array(self.speeds, dtype=float)
