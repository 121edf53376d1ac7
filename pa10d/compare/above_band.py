"""Ripple that at a joint's usual speed is faster than the low-pass lets through: not judged."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import listed
from pa10d.compare.orders import OrderSpectrum

Array = NDArray[np.float64]

WELL_ABOVE = 1.5  # times a line's frequency
HIGHEST = 0.45  # of the sampling rate: a low-pass ends at half of it


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
        enough = _well_above(largest, found.rate)
        said[j] = (
            f"an error that comes again {listed(often)} times a turn lies above the low-pass of "
            f"{cutoff:g} Hz, the largest at about {largest:.0f} Hz, and is not judged; a fit with "
            f"a higher cut-off can look at it: identify … --cutoff {enough}"
        )
    return said


def _well_above(frequency: float, rate: float) -> str:
    """Hz, two digits: what lies at the edge of a low-pass is half gone; as far as samples go."""
    return f"{float(f'{min(WELL_ABOVE * frequency, HIGHEST * rate):.2g}'):g}"
