"""The same speed under different loads: friction that grows with the transmitted torque."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field

from pa10d.common.errors import UserError
from pa10d.trajectory.kinds.base import Array, Count, Kind, Share
from pa10d.trajectory.kinds.strokes import fastest, to_and_fro
from pa10d.trajectory.plan import Plan, joined
from pa10d.trajectory.poses import Surroundings

TRIES = 300
HALF_TRAVEL = 0.35  # rad to either side: the load hardly changes on the way
SPREAD = 0.05  # of the torque limit, by which loads must differ to be called so


class LoadSweep(Kind):
    """One joint after the other: poses in which gravity loads it differently, the same speeds."""

    kind: ClassVar[str] = "load_sweep"
    title: ClassVar[str] = "The same speeds in poses that load the joint differently"

    count: Count = Field(default=5, description="how many poses")
    speeds: list[Share] = Field(
        min_length=1, default=[0.05, 0.3], description="shares of the speed limit"
    )

    def build(self, around: Surroundings) -> Plan:
        """Per joint and pose every speed, to and fro."""
        joints, segments, notes = self.chosen(around), [], []
        home = self.home(around)
        for j in joints:
            poses, loads = self._poses(around, home, j)
            if np.ptp(loads) < SPREAD * min(around.limits.torque[j], 1e6):
                notes.append(
                    f"joint {j + 1}: gravity loads it by {loads.min():.2g} … {loads.max():.2g} N·m "
                    "whatever the pose; a payload or accelerations of other joints must load it"
                )
            for pose, load in zip(poses, loads, strict=True):
                span = (pose[j] - HALF_TRAVEL, pose[j] + HALF_TRAVEL)
                for share in self.speeds:
                    limit = around.limits.acceleration[j]
                    speed = fastest(span, share * around.limits.velocity[j], limit, 0.3)
                    label = f"joint {j + 1} at {load:.3g} N·m"
                    segments += to_and_fro(pose, j, span, speed, 3.0, limit, label)
        return joined(self.kind, joints, segments, around, notes)

    def _poses(self, around: Surroundings, home: Array, j: int) -> tuple[list[Array], Array]:
        """Allowed poses whose gravity loads spread evenly from the least to the most."""
        rng = np.random.default_rng([self.seed, j])
        mid, half = around.room.middle, around.room.half
        drawn = mid + 0.8 * half * rng.uniform(-1, 1, (TRIES, around.robot.n))
        drawn = np.vstack([home, drawn])
        room = np.maximum(half[j] - HALF_TRAVEL, 0.0)
        drawn[:, j] = mid[j] + np.clip(drawn[:, j] - mid[j], -room, room)
        ends = np.repeat(drawn, 3, axis=0)
        ends[:, j] += np.tile([-HALF_TRAVEL, 0.0, HALF_TRAVEL], len(drawn))
        fine = drawn[around.allowed(ends).reshape(-1, 3).all(axis=1)]
        usable = np.array([pose for pose in fine if around.reachable(pose)])
        if len(usable) < self.count:
            raise UserError(
                f"joint {j + 1}: only {len(usable)} of {TRIES} random poses are free; expected "
                f"at least {self.count}: wider limits, fewer poses or less around it (environment)"
            )
        loads = around.gravity(usable)[:, j]
        wanted = np.linspace(loads.min(), loads.max(), self.count)
        rows: list[int] = []
        for load in wanted:
            order = np.argsort(np.abs(loads - load))
            rows.append(next(int(k) for k in order if int(k) not in rows))
        return [usable[k] for k in rows], loads[rows]
