"""All axes' drive numbers to SI units and back, as arrays made once."""

from __future__ import annotations

from math import isfinite

import numpy as np

from backends.canopen_cia402.exchange import Exchange
from backends.faults import fault
from backends.limits import AxisLimits, axis_limits
from backends.protocol import Array, Feedback
from backends.scaling import Scaling, scaling_of
from pa10d.profile import Profile

INT16 = 32767.0


class Scales:
    """``fill`` for what was measured, ``per_mille`` for what is commanded."""

    def __init__(self, profile: Profile) -> None:
        self.axes: list[Scaling] = [scaling_of(drive) for drive in profile.drives or []]
        self.limits: list[AxisLimits] = axis_limits(profile)
        sign = np.array([s.sign for s in self.axes], float)
        rated = np.array([s.rated for s in self.axes])
        self._radians_per_count = sign / np.array([s.counts_per_radian for s in self.axes])
        self._zero = np.array([s.zero_offset for s in self.axes])
        self._torque_of_per_mille = sign * rated / 1000.0
        self._per_mille_of_torque = sign * 1000.0 / rated
        most = np.array([limits.torque for limits in self.limits]) * 1000.0 / rated
        self._most: list[float] = np.minimum(most, INT16).tolist()

    def counts_per_period(self, period: float) -> list[float]:
        """Counts that each axis can pass in ``period`` s at its velocity limit."""
        pairs = zip(self.limits, self.axes, strict=True)
        return [limit.velocity * axis.counts_per_radian * period for limit, axis in pairs]

    def fill(self, exchange: Exchange, feedback: Feedback) -> None:
        """The last values of every axis into ``feedback``'s arrays."""
        np.multiply(exchange.position, self._radians_per_count, out=feedback.q)
        np.subtract(feedback.q, self._zero, out=feedback.q)
        np.multiply(exchange.torque, self._torque_of_per_mille, out=feedback.tau)
        feedback.status[:] = exchange.status
        np.subtract(exchange.cycle, exchange.seen_in, out=feedback.age)
        feedback.answers = exchange.answers

    def per_mille(self, torque: Array) -> list[int]:
        """Joint-side torques (n,), N·m, as the drives want them, within the torque limits."""
        scaled = (torque * self._per_mille_of_torque).tolist()
        limited = zip(scaled, self._most, strict=True)
        # plain floats: seven of them are done before numpy has begun
        return [round(x) if -m <= x <= m else _limited(x, m) for x, m in limited]


def _limited(value: float, most: float) -> int:
    if not isfinite(value):
        raise fault("torque", f"a torque command is {value}")
    return round(max(-most, min(most, value)))
