"""What the loop writes down in every cycle: one row of float64 with named places."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SCALARS = (
    "sequence",  # of this record, from 0
    "time",  # s on the loop's clock
    "state",  # ArmState
    "motion",  # number of the motion under way, 0: none
    "row",  # of the motion
    "recording",  # 1: belongs to the run of this motion
    "fault",  # 1: a fault is latched
    "late",  # s, how late the cycle began
    "busy",  # s of processor time that the cycle before took in the control thread
    "missed",  # cycles so far that did not end within their period
)
VECTORS = (
    "q",  # rad, measured
    "dq",  # rad/s, estimated
    "tau",  # N·m, measured
    "q_ref",  # rad
    "dq_ref",  # rad/s
    "ddq_ref",  # rad/s²
    "torque",  # N·m, sent
    "status",  # the device's own word, see backends/device.py
    "age",  # cycles since the axis answered
    "temperature",  # °C, NaN where not measured
)


class RecordLayout:
    """Places of the fields in rows of ``width`` numbers, for an arm of n joints."""

    def __init__(self, n: int) -> None:
        self.n = n
        self.width = len(SCALARS) + len(VECTORS) * n

    @cached_property
    def scalars(self) -> dict[str, int]:
        """Field -> column."""
        return {name: k for k, name in enumerate(SCALARS)}

    @cached_property
    def vectors(self) -> dict[str, slice]:
        """Field -> its n columns."""
        first, n = len(SCALARS), self.n
        return {v: slice(first + k * n, first + (k + 1) * n) for k, v in enumerate(VECTORS)}

    def get(self, rows: Array, field: str) -> Array:
        """The field of rows (…, width): (…,) or (…, n)."""
        if field in self.scalars:
            return rows[..., self.scalars[field]]
        return rows[..., self.vectors[field]]
