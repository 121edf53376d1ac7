"""A small step of one joint: how its servo answers."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from pa10d.common.errors import UserError
from pa10d.trajectory.kinds.base import Kind
from pa10d.trajectory.motions import Drawing, Knots, move_time
from pa10d.trajectory.plan import Plan, Segment, joined
from pa10d.trajectory.poses import Surroundings

BEFORE = 0.2  # s at rest
MOST = 0.2  # rad (m)


class SmallStep(Kind):
    """One joint after the other goes a small way and back, as sharply as its limits of speed and
    acceleration allow, and rests after each: rise, overshoot and settling show in the run."""

    kind: ClassVar[str] = "step"
    title: ClassVar[str] = "Small steps of one joint at a time: rise, overshoot, settling"

    size: Annotated[float, Field(gt=0, le=MOST, allow_inf_nan=False)] = Field(
        default=0.05, description="rad (m of a joint that slides)"
    )
    hold: Annotated[float, Field(ge=0.2, le=10)] = Field(
        default=1.0, description="s at rest after each step"
    )

    def build(self, around: Surroundings) -> Plan:
        """One segment per joint, there and back."""
        joints = self.chosen(around)
        segments = [
            Segment(self._there_and_back(around, j), f"joint {j + 1}", j + 1) for j in joints
        ]
        return joined(self.kind, joints, segments, around)

    def _there_and_back(self, around: Surroundings, j: int) -> Knots:
        pose, limits = self.home(around), around.limits
        lower, upper = around.free_range(pose, j)
        side = 1.0 if upper - pose[j] >= self.size else -1.0
        if side < 0 and pose[j] - lower < self.size:
            raise UserError(
                f"joint {j + 1}: no room for a step of {self.size:g} around {pose[j]:.3g}; "
                "expected a smaller step, or another pose"
            )
        there = np.array(pose)
        there[j] += side * self.size
        sharp = move_time(there - pose, limits.velocity, limits.acceleration)
        drawing = Drawing(pose)
        drawing.rest(BEFORE)
        for end in (there, pose):
            drawing.to(end, sharp)
            drawing.rest(self.hold)
        return drawing.knots()
