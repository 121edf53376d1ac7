"""A rising frequency at two sizes: elasticity and delay."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field

from pa10d.common.errors import UserError
from pa10d.trajectory.kinds.base import Kind, Positive, Share
from pa10d.trajectory.motions import Chirp
from pa10d.trajectory.plan import Plan, Segment, joined
from pa10d.trajectory.poses import Surroundings


class ChirpSweep(Kind):
    """One joint after the other: a sine from low to high frequency, small and large."""

    kind: ClassVar[str] = "chirp"
    title: ClassVar[str] = "A rising frequency, at two amplitudes: elasticity, delay"

    low: Positive = Field(default=0.2, description="Hz at the beginning")
    high: Positive = Field(default=12.0, description="Hz at the end")
    seconds: Positive = Field(default=20.0, description="s of one chirp")
    amplitude: Positive = Field(default=0.3, description="rad at low frequency, at most")
    sizes: list[Share] = Field(
        min_length=1, default=[0.6, 0.25], description="shares of speed and acceleration limits"
    )

    def build(self, around: Surroundings) -> Plan:
        """One segment per joint and size."""
        if self.high <= self.low:
            raise UserError(f"chirp: high: found {self.high:g} Hz, expected more than {self.low:g}")
        joints, pose, segments = self.chosen(around), self.home(around), []
        n, limits = around.robot.n, around.limits
        for j in joints:
            lower, upper = around.free_range(pose, j)
            for size in self.sizes:
                swing = np.zeros(n)
                swing[j] = size * min(self.amplitude, 0.45 * (upper - lower)) / max(self.sizes)
                centre = np.array(pose)
                centre[j] = np.clip(pose[j], lower + swing[j], upper - swing[j])
                chirp = Chirp(
                    self.seconds, 1.0, centre, swing, size * limits.velocity,
                    size * limits.acceleration, self.low, self.high,
                )  # fmt: skip
                label = f"joint {j + 1}, {size:g} of its limits"
                segments.append(Segment(chirp.gentle(limits), label))
        return joined(self.kind, joints, segments, around)
