"""Sines of one joint where gravity does not act: above which speed is friction linear?

The paper (2.2) re-mounts the arm and applies a sinusoidal torque. Here a pose takes the place of
re-mounting, and the position is what is commanded: it stays where it is safe, and the torque that
this takes is a sine plus friction. For the estimate it makes no difference which of the two is
the sine, see docs/excitation.md.
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np
from pydantic import Field

from pa10d.trajectory.kinds.base import Array, Count, Kind, Positive, Share
from pa10d.trajectory.motions import Sines
from pa10d.trajectory.plan import Plan, Segment, joined
from pa10d.trajectory.poses import Surroundings, gravity_free_pose

ACCELERATION = 0.6  # share of the limit
TRAVEL = 0.45  # of the free range


class BoundaryVelocity(Kind):
    """Fast sines that cover all speeds, and slow ones that dwell where friction is not linear."""

    kind: ClassVar[str] = "boundary_velocity"
    title: ClassVar[str] = (
        "Sines of one joint without gravity: from which speed is friction linear?"
    )

    speed: Share = Field(default=0.9, description="share of the speed limit at the peak")
    period: Positive = Field(
        default=4.0, description="s, longer where the acceleration limit asks for it"
    )
    cycles: Count = Field(default=10, description="fast sines; their spread gives the bands")
    slow: Share = Field(
        default=0.25, description="speed of the slow sines, share of the fast ones'"
    )
    slow_cycles: Count = Field(default=4, description="slow sines, over the same angle")

    def build(self, around: Surroundings) -> Plan:
        """Per joint two segments, in the pose that leaves least gravity."""
        joints = self.chosen(around)
        segments: list[Segment] = []
        notes: list[str] = []
        weightless: list[int] = []
        for j in joints:
            pose, free = self._pose(around, j, notes)
            weightless += [j + 1] if free else []
            peak, period, centre = self._size(around, pose, j)
            pose = pose.copy()
            pose[j] = centre
            for word, share, cycles in (
                ("fast", 1.0, self.cycles),
                ("slow", self.slow, self.slow_cycles),
            ):
                sine = self._sine(pose, j, share * peak, period / share, cycles)
                label = f"joint {j + 1}, {word}"
                segments.append(Segment(sine.gentle(around.limits), label, j + 1))
        plan = joined(self.kind, joints, segments, around, notes)
        return replace(plan, weightless=tuple(weightless))

    def _pose(self, around: Surroundings, j: int, notes: list[str]) -> tuple[Array, bool]:
        """Where the others stand, and whether gravity then leaves the joint alone."""
        if self.pose is not None:
            notes.append(f"joint {j + 1}: pose as given; gravity is what the pose makes it")
            return self.home(around), False
        wanted = self.speed * around.limits.velocity[j] * self.period / (2 * np.pi)
        travel = min(wanted, TRAVEL * around.limits.half[j])
        found = gravity_free_pose(around, j, travel, self.seed)
        if found.free:
            notes.append(f"joint {j + 1}: gravity does not act in this pose")
            return found.pose, True
        notes.append(
            f"joint {j + 1}: gravity acts in every pose ({100 * found.share:.0f} % of its worst is "
            "left in the best one) and must be fitted along or subtracted"
        )
        return self.home(around), False

    def _size(self, around: Surroundings, pose: Array, j: int) -> tuple[float, float, float]:
        """Peak speed, period, centre."""
        lower, upper = around.free_range(pose, j)
        limits = around.limits
        peak = self.speed * limits.velocity[j]
        period = max(self.period, 2 * np.pi * peak / (ACCELERATION * limits.acceleration[j]))
        amplitude = min(peak * period / (2 * np.pi), TRAVEL * (upper - lower))
        peak = amplitude * 2 * np.pi / period
        centre = float(np.clip(pose[j], lower + amplitude, upper - amplitude))
        return peak, period, centre

    def _sine(self, pose: Array, j: int, peak: float, period: float, cycles: int) -> Sines:
        n = len(pose)
        amplitude = np.zeros(n)
        amplitude[j] = peak * period / (2 * np.pi)
        return Sines(cycles * period, 1.0, pose, amplitude, np.full(n, 1 / period), np.zeros(n))
