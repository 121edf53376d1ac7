"""One joint moves, all others stand: what belongs to it alone, and what it does to others."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from pa10d.trajectory.fourier import fourier_basis
from pa10d.trajectory.kinds.base import Array, Count, Kind, Positive, Share
from pa10d.trajectory.motions import Fourier
from pa10d.trajectory.plan import Plan, Segment, joined
from pa10d.trajectory.poses import Surroundings

GRID = 400


class SingleJoint(Kind):
    """One joint after the other follows a Fourier series over its free range, in several poses of
    the others."""

    kind: ClassVar[str] = "single_joint"
    title: ClassVar[str] = "One joint at a time, all others at rest, in several poses"

    period: Positive = Field(default=10.0, description="s")
    harmonics: Annotated[int, Field(ge=1, le=20)] = 5
    cycles: Count = Field(default=1, description="periods per pose")
    poses: Count = Field(
        default=2, description="poses of the other joints: the given one and random ones"
    )
    speed: Share = Field(default=0.8, description="share of the speed and acceleration limits")

    def build(self, around: Surroundings) -> Plan:
        """One segment per joint and pose."""
        joints, segments = self.chosen(around), []
        for j in joints:
            rng = np.random.default_rng([self.seed, j])
            poses = [self.home(around)]
            poses += [around.random_pose(rng, 0.5) for _ in range(self.poses - 1)]
            for number, pose in enumerate(poses):
                series = self._series(around, pose, j, rng)
                segments.append(Segment(series, f"joint {j + 1}, pose {number + 1}"))
        return joined(self.kind, joints, segments, around)

    def _series(
        self, around: Surroundings, pose: Array, j: int, rng: np.random.Generator
    ) -> Fourier:
        lower, upper = around.free_range(pose, j)
        n, h, fundamental = around.robot.n, self.harmonics, 1.0 / self.period
        x = rng.normal(size=2 * h) / np.tile(np.arange(1, h + 1), 2)
        t = np.arange(GRID) / GRID * self.period
        swing, speed, rise = (basis[:, 1:] @ x for basis in fourier_basis(fundamental, h, t))
        limits = around.limits
        x *= min(
            0.95 * (upper - lower) / np.ptp(swing),
            self.speed * limits.velocity[j] / np.abs(speed).max(),
            self.speed * limits.acceleration[j] / np.abs(rise).max(),
        )
        swing = fourier_basis(fundamental, h, t)[0][:, 1:] @ x
        centre = np.array(pose)
        centre[j] = np.clip(pose[j], lower - swing.min(), upper - swing.max())
        a, b = np.zeros((h, n)), np.zeros((h, n))
        a[:, j], b[:, j] = x[:h], x[h:]
        return Fourier(self.cycles * self.period, 1.0, fundamental, centre, a, b).gentle(limits)
