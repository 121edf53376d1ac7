"""Ripple that at a joint's usual speed is faster than the low-pass lets through: not judged."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import listed
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
        often = [f"{order:.4g} ({size:.2g} N·m)" for order, size in above]
        largest = found.frequency(above[0][0])
        said[j] = (
            f"an error that comes again {listed(often)} times a turn lies above the low-pass of "
            f"{cutoff:g} Hz, the largest at about {largest:.0f} Hz, and is not judged; a fit with "
            f"a higher cut-off can look at it: identify … --cutoff {_well_above(largest)}"
        )
    return said


def _well_above(frequency: float) -> str:
    """Hz, two digits: what lies at the edge of a low-pass is half gone."""
    return f"{float(f'{1.5 * frequency:.2g}'):g}"
