"""Sines of all joints, as the paper verifies its controller (3.2.2)."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field

from pa10d.common.errors import UserError
from pa10d.trajectory.kinds.base import Count, Kind, Positive
from pa10d.trajectory.motions import Sines
from pa10d.trajectory.plan import Plan, Segment, joined
from pa10d.trajectory.poses import Surroundings


class Tracking(Kind):
    """Every joint swings by the same angle with the same period."""

    kind: ClassVar[str] = "tracking"
    title: ClassVar[str] = "Sines of all joints: how well does the controller follow?"

    amplitude: Positive = Field(default=float(np.pi / 6), description="rad")
    period: Positive = Field(default=4.0, description="s; the paper takes 4 and 40")
    cycles: Count = Field(default=3, description="periods at full amplitude")

    def build(self, around: Surroundings) -> Plan:
        """One segment."""
        joints, pose = self.chosen(around), self.home(around)
        amplitude = np.zeros(around.robot.n)
        amplitude[joints] = self.amplitude
        omega, limits = 2 * np.pi / self.period, around.limits
        for word, needed, limit, unit in (
            ("speed", omega * self.amplitude, limits.velocity, "rad/s"),
            ("acceleration", omega**2 * self.amplitude, limits.acceleration, "rad/s²"),
        ):
            for j in joints:
                if needed > limit[j]:
                    raise UserError(
                        f"joint {j + 1}: a sine of {self.amplitude:.3g} rad in {self.period:g} s "
                        f"needs a {word} of {needed:.3g} {unit}, allowed are {limit[j]:.3g}; "
                        "expected a smaller amplitude or a longer period"
                    )
        n = around.robot.n
        frequency = np.full(n, 1 / self.period)
        sines = Sines(self.cycles * self.period, 1.0, pose, amplitude, frequency, np.zeros(n))
        label = f"{self.cycles} cycles of {self.period:g} s"
        return joined(self.kind, joints, [Segment(sines.gentle(limits), label)], around)
