"""The same minute before and after a long warm motion: what drifts is temperature."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from pa10d.trajectory.kinds.base import Array, Kind, Positive, Share
from pa10d.trajectory.motions import Sines
from pa10d.trajectory.plan import Plan, Segment, joined
from pa10d.trajectory.poses import Surroundings

SLOW_PERIODS, FAST_PERIODS = (10.0, 15.0), (4.0, 6.0)  # s, whole numbers of them in a minute


class WarmUp(Kind):
    """A reference minute, minutes of brisk motion, the reference minute again."""

    kind: ClassVar[str] = "warm_up"
    title: ClassVar[str] = "Long motion; its first minute is repeated at the end"

    minutes: Annotated[float, Field(gt=0, le=120)] = Field(
        default=8.0, description="of brisk motion between the two reference minutes"
    )
    reference: Positive = Field(default=60.0, description="s of the part that is repeated")
    speed: Share = Field(default=0.6, description="share of the speed limits of the brisk motion")

    def build(self, around: Surroundings) -> Plan:
        """Three segments; the labels say which are to be compared."""
        joints, pose = self.chosen(around), self.home(around)
        slow = self._sines(around, joints, pose, SLOW_PERIODS, 0.5 * self.speed, self.reference)
        fast = self._sines(around, joints, pose, FAST_PERIODS, self.speed, 60.0 * self.minutes)
        segments = [
            Segment(slow, "first minute"),
            Segment(fast, "warming"),
            Segment(slow, "last minute"),
        ]
        return joined(self.kind, joints, segments, around)

    def _sines(
        self,
        around: Surroundings,
        joints: list[int],
        pose: Array,
        periods: tuple[float, float],
        share: float,
        seconds: float,
    ) -> Sines:
        """Sines of two periods in turn, so that neighbours do not move in step."""
        n, limits = around.robot.n, around.limits
        period = np.array([periods[j % 2] for j in range(n)])
        omega = 2 * np.pi / period
        amplitude, centre = np.zeros(n), np.array(pose)
        for j in joints:
            lower, upper = around.free_range(pose, j)
            amplitude[j] = min(
                share * limits.velocity[j] / omega[j],
                0.5 * limits.acceleration[j] / omega[j] ** 2,
                0.4 * (upper - lower),
            )
            centre[j] = np.clip(pose[j], lower + amplitude[j], upper - amplitude[j])
        frequency = 1.0 / period
        wished = Sines(seconds, 1.0, centre, amplitude, frequency, np.zeros(n))
        for _ in range(40):  # all joints together may meet what each alone does not
            t = np.arange(0.0, float(np.lcm(int(periods[0]), int(periods[1]))), 0.1)
            if around.allowed(wished.path(t)[0]).all():
                break
            amplitude = 0.85 * amplitude
            centre = np.where(amplitude > 0, 0.15 * pose + 0.85 * centre, centre)
            wished = Sines(seconds, 1.0, centre, amplitude, frequency, np.zeros(n))
        return wished.gentle(limits)
