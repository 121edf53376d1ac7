"""Small swings: what a joint does just after its direction changes."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field

from pa10d.trajectory.kinds.base import Array, Count, Kind, Positive
from pa10d.trajectory.motions import Drawing, Knots, move_time
from pa10d.trajectory.plan import Plan, Segment, joined
from pa10d.trajectory.poses import Surroundings

SLOW = 0.5  # of speed and acceleration limits at most


class Reversals(Kind):
    """One joint after the other swings by small angles, under loads of both signs where gravity
    gives them: hysteresis shows as a loop against the angle, backlash as a gap without torque."""

    kind: ClassVar[str] = "reversals"
    title: ClassVar[str] = "Small swings: what happens just after a reversal"

    amplitudes: list[Positive] = Field(
        min_length=1, default=[0.002, 0.005, 0.01, 0.03, 0.1], description="rad to either side"
    )
    cycles: Count = Field(default=3, description="swings per amplitude")
    period: Positive = Field(default=2.0, description="s of a swing at least")
    both_loads: bool = Field(default=True, description="in two poses that load the joint both ways")

    def build(self, around: Surroundings) -> Plan:
        """One segment per pose and amplitude."""
        joints, segments, notes = self.chosen(around), [], []
        for j in joints:
            poses = self._poses(around, j)
            loads = [around.load(pose, j) for pose in poses]
            if self.both_loads and min(loads) >= 0.0 and max(loads) <= 1e-6:
                notes.append(f"joint {j + 1}: gravity loads it in no pose")
            for pose, load in zip(poses, loads, strict=True):
                for amplitude in self.amplitudes:
                    label = f"joint {j + 1} ±{amplitude:g} rad at {load:.3g} N·m"
                    segments.append(Segment(self._swings(around, pose, j, amplitude), label))
        return joined(self.kind, joints, segments, around, notes)

    def _poses(self, around: Surroundings, j: int) -> list[Array]:
        """The pose itself, or two mirror-like ones under loads of both signs."""
        home, reach = self.home(around), max(self.amplitudes)
        if not self.both_loads:
            return [home]
        rng = np.random.default_rng([self.seed, j])
        drawn = [home, *(around.random_pose(rng, 0.6) for _ in range(40))]
        poses = np.clip(drawn, around.limits.lower + reach, around.limits.upper - reach)
        ends = np.repeat(poses, 2, axis=0)
        ends[:, j] += np.tile([-reach, reach], len(poses))
        usable = poses[around.allowed(ends).reshape(-1, 2).all(axis=1)]
        if not len(usable):
            return [home]
        loads = around.gravity(usable)[:, j]
        if np.ptp(loads) < 1e-6:
            return [usable[0]]
        return [usable[int(np.argmin(loads))], usable[int(np.argmax(loads))]]

    def _swings(self, around: Surroundings, pose: Array, j: int, amplitude: float) -> Knots:
        limits = around.limits
        up = np.array(pose)
        down = np.array(pose)
        up[j] += amplitude
        down[j] -= amplitude
        quickest = move_time(
            np.array([2 * amplitude]), SLOW * limits.velocity[[j]], SLOW * limits.acceleration[[j]]
        )
        half = max(0.5 * self.period, quickest)
        drawing = Drawing(pose)
        drawing.rest(0.2)
        drawing.to(up, half)
        begin = drawing.time
        for _ in range(self.cycles):
            drawing.to(down, half)
            drawing.to(up, half)
        end = drawing.time
        drawing.to(pose, half)
        return drawing.knots(begin, end)
