"""Where a long run is cut."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from pa10d.regression.equation import decimation, edge_time

PIECE = 40_000  # raw samples: 7 joints' columns of this many take about 100 MB while filtered


def cuts(samples: int, rate: float, cutoff: float) -> list[tuple[int, int, int, int]]:
    """(start, stop) in raw samples and (first, last) in the piece's own decimated samples that
    count: together they count every decimated sample of the run once."""
    factor = decimation(rate, cutoff)
    overlap = int(np.ceil(edge_time(rate, cutoff) * rate / factor)) + 1
    length = max(PIECE // factor, 8 * overlap)
    total = -(-samples // factor)
    pieces = max(1, round(total / length))
    bounds = np.linspace(0, total, pieces + 1).astype(int)
    out = []
    for begin, end in pairwise(bounds):
        left = max(0, begin - overlap)
        right = min(total, end + overlap)
        stop = min(samples, right * factor)
        out.append((int(left * factor), int(stop), int(begin - left), int(end - left)))
    return out
