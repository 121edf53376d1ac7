"""Ripple that at a joint's usual speed is faster than the low-pass lets through: not judged."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.compare.orders import OrderSpectrum

Array = NDArray[np.float64]


def lines_above_band(
    orders: Sequence[OrderSpectrum | None], cutoff: float, rms: Array
) -> dict[int, str]:
    """By joint (0-based), in words: where lines that the low-pass (Hz) takes away have more torque
    than all that it leaves has error, (n,) N·m."""
    said = {}
    for j, found in enumerate(orders):
        above = found.above(cutoff) if found else []
        if not found or sum(size**2 for _, size in above) / 2.0 <= rms[j] ** 2:
            continue
        largest, size = above[0]
        said[j] = (
            f"an error that comes again {largest:.4g} times a turn ({size:.2g} N·m) lies above the "
            f"low-pass of {cutoff:g} Hz, at about {found.frequency(largest):.0f} Hz, and is not "
            "judged; only a fit with a higher cut-off can look at it"
        )
    return said
