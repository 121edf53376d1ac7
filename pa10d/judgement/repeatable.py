"""Does an error come again where the motion does? Noise does not, whatever its colour.

Two passes of one motion have the model's error in common and nothing else, so their product says
how much of it there is. Slow noise remembers the earlier pass; so the errors are whitened first
by what they remember of themselves within a fraction of a period (Haugh 1976: two series are
independent if their innovations do not go together). Between two runs no noise can remember, so
there an error too slow to leave innovations counts as well, as the few samples that it is worth
(Bartlett 1935).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
import scipy.fft
from numpy.typing import NDArray

from pa10d.judgement.repeats import Pass, passes
from pa10d.judgement.residuals import RunResidual

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

ORDER = 12  # samples of the band that the whitening looks back
FEWEST_WORTH = 3.0  # independent samples below which a correlation is an accident
FEWEST = 60  # pairs of innovations below which nothing is said


@dataclass(frozen=True)
class Repeatable:
    """Of one joint. p_value: that errors which know nothing of each other go together as well;
    share: of the squared error, that both passes have in common; pairs: of samples."""

    p_value: float
    share: float
    pairs: int


def repeatable(runs: Sequence[RunResidual]) -> list[Repeatable | None]:
    """Per joint; None where no motion comes again for long enough."""
    n = runs[0].error.shape[1]
    found = list(passes(list(runs)))
    return [_of_joint(found, j) for j in range(n)]


def _of_joint(found: Sequence[Pass], joint: int) -> Repeatable | None:
    products, one_square, other_square, shared, slow = [], 0.0, 0.0, 0.0, []
    for pair in found:
        one, other, counts = pair.in_band(joint)
        if counts.sum() < FEWEST:
            continue
        shared += float(one[counts] @ other[counts])
        one_square += float(one[counts] @ one[counts])
        other_square += float(other[counts] @ other[counts])
        if pair.apart:
            slow.append(_go_together(one, other, counts))
        clear, first, second = _innovations(one, other, counts)
        products.append((first * second)[clear])
    together = np.concatenate(products) if products else np.empty(0)
    if len(together) < FEWEST:
        return None
    z = float(together.sum() / np.sqrt(max(float(together @ together), 1e-300)))
    share = shared / max(0.5 * (one_square + other_square), 1e-300)
    tests = [float(scipy.stats.norm.sf(z)), *slow]
    return Repeatable(min(1.0, len(tests) * min(tests)), share, len(together))


def _go_together(one: Array, other: Array, counts: Mask) -> float:
    """p of the correlation of two series (M,) that know nothing of each other, one-sided."""
    x, y = (np.where(counts, v - v[counts].mean(), 0.0) for v in (one, other))
    rho = [_memory(v) for v in (x, y)]
    worth = float(counts.sum()) / max(1.0 + 2.0 * float(np.sum(rho[0][1:] * rho[1][1:])), 1.0)
    r = float(x @ y) / max(float(np.sqrt((x @ x) * (y @ y))), 1e-300)
    if worth < FEWEST_WORTH:
        return 1.0
    t = r * np.sqrt((worth - 2.0) / max(1.0 - r**2, 1e-12))
    return float(scipy.stats.t.sf(t, worth - 2.0))


def _memory(x: Array) -> Array:
    """Autocorrelation (M/2,)."""
    size = scipy.fft.next_fast_len(2 * len(x), real=True)
    gamma = scipy.fft.irfft(np.abs(scipy.fft.rfft(x, size)) ** 2, size)[: len(x) // 2]
    return np.asarray(gamma / max(float(gamma[0]), 1e-300))


def _innovations(one: Array, other: Array, counts: NDArray[np.bool_]) -> tuple[Mask, Array, Array]:
    """Both series (M,) less what their own past says of them, and where that past is known."""
    rows = np.asarray(np.lib.stride_tricks.sliding_window_view(counts, ORDER + 1).all(axis=1))
    pasts = [
        np.lib.stride_tricks.sliding_window_view(np.where(counts, x, 0.0), ORDER + 1)
        for x in (one, other)
    ]
    if rows.sum() < 4 * ORDER:  # too broken for a past: as they are
        return counts, one, other
    both = np.concatenate([p[rows] for p in pasts])
    past, now = both[:, :-1], both[:, -1]
    ridge = 1e-8 * float(np.mean(now**2)) * len(now)
    weights = np.linalg.solve(past.T @ past + ridge * np.eye(ORDER), past.T @ now)
    first, second = (p[:, -1] - p[:, :-1] @ weights for p in pasts)
    return rows, first, second
