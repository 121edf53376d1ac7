"""Torque that its channel mostly does not show: it comes back to one value whatever the joint does.

What moves the joint is below the channel's least step, or its motor was off. A logger that repeats
old values repeats many.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.measurement.spans import spans

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

MOSTLY = 0.5  # of the moving samples at one value
OFTEN = 10  # stays at it


@dataclass(frozen=True)
class Dull:
    """level: N·m (N) that a torque mostly shows; share: of the samples in which its joint moves;
    step: N·m (N) to the nearest other value."""

    level: float
    share: float
    step: float


def dull(tau: Array, moving: Flags) -> Dull | None:
    """tau (N,) N·m (N) of one joint, moving (N,); None where it shows what moves the joint."""
    values, counts = np.unique(tau[moving], return_counts=True)
    if len(values) < 2:
        return None
    most = int(np.argmax(counts))
    stays = len(spans((tau == values[most]) & moving))
    if not 0 < most < len(values) - 1 or counts[most] <= MOSTLY * moving.sum() or stays <= OFTEN:
        return None
    return Dull(
        level=float(values[most]) + 0.0,
        share=float(counts[most] / moving.sum()),
        step=float(np.diff(values[most - 1 : most + 2]).min()),
    )
