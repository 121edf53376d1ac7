"""Stamps that scatter about equal steps: were the samples taken so, or only stamped so?

A loop that is late reads its encoders late, and its stamps are right; a logger that is late stamps
late what was read on time, and its stamps are wrong. The stamps look alike, the positions do not: a
joint that was read δ late stands q̇·δ farther than its neighbours in time have it. So each sample is
held against a cubic through two samples on either side, and the share of q̇·δ that is found there
tells: all of it, the stamps are right; nothing of it, the steps were equal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

CUBIC = np.array([-1.0, 4.0, 4.0, -1.0]) / 6.0  # of the neighbours, at the sample between them
HALF = 0.5  # of the scatter: with less than that found in the positions, equal steps are nearer
SURE = 4.0  # standard errors that it has to be less
COMB = 0.2  # of a period: stamps that know of no equal steps scatter by 0.29
FARTHEST = 10.0  # periods that a stamp may be off: what is farther is another sample's
BLOCK = 64  # samples: neighbours share their cubics, and servos swing
FEWEST_BLOCKS = 10
FIRST = 4096  # stamps that a step is sought with
MOST_MISSING = 0.1  # of the samples


def evened(t: Array, q: Array) -> Array | None:
    """(N,) s: the equal steps, some perhaps missing, at which positions (N, n) were read that were
    stamped t (N,), rising; None where the stamps are right, or nobody can tell."""
    count, period, late = min(
        (_held_against(t, count) for count in _counts(t)), key=lambda found: float(found[2].std())
    )
    if np.abs(late).max() > FARTHEST * period:
        return None
    if late.std() > COMB * period and _lost(late, period):
        return None
    share, error = found_in_positions(q, count, late / period)
    return np.asarray(t - late) if share + SURE * error < HALF else None


def _counts(t: Array) -> list[Counts]:
    """Which of equal steps each stamp may be of: one after the other; or some of them left out, by
    a step and a start that are known the better, the more stamps they were fitted to."""
    seen = min(FIRST, len(t))
    step, start = _beat(t[:seen])
    while True:
        nearest = np.rint((t[:seen] - start) / step).astype(np.int64)
        if seen >= len(t):
            beside = [nearest - nearest[0]] if np.all(np.diff(nearest) > 0) else []
            return [np.arange(len(t)), *beside]
        step, start = (float(x) for x in np.polyfit(nearest.astype(float), t[:seen], 1))
        seen *= 2


def _beat(t: Array) -> tuple[float, float]:
    """Step and start, s, of the comb nearest to stamps (N,) s: where exp(2πi·t/step) add up
    to most, with no or some steps left out."""
    span, at_least = float(t[-1] - t[0]), len(t) - 1
    best = (0.0, span / at_least, float(t[0]))
    for steps in np.arange(at_least, at_least * (1.0 + MOST_MISSING) + 1.0, 0.25):
        turns = np.exp(2j * np.pi * ((t - t[0]) * (steps / span))).mean()
        if abs(turns) > best[0]:
            step = span / float(steps)
            best = (abs(turns), step, float(t[0] + np.angle(turns) / (2.0 * np.pi) * step))
    return best[1], best[2]


def _lost(late: Array, period: float) -> bool:
    """Do stamps that come in bursts leave their steps? Then some of the samples
    are missing, and nobody knows which."""
    blocks = len(late) // BLOCK
    middle = np.median(late[: blocks * BLOCK].reshape(blocks, BLOCK), axis=1)
    return blocks < FEWEST_BLOCKS or bool(np.ptp(middle) > HALF * period)


def _held_against(t: Array, count: Counts) -> tuple[Counts, float, Array]:
    """count, the step s that fits best, and how much later than such steps each stamp is, s."""
    step, start = np.polyfit(count.astype(float), t, 1)
    return count, float(step), t - start - step * count


def found_in_positions(q: Array, count: Counts, late: Array) -> tuple[float, float]:
    """Share of the scatter that the positions show, and its standard error (inf: nobody can tell).

    q (N, n) rad; count (N,): steps since the first; late (N,): stamps after equal steps, in
    steps.
    """
    middle = np.flatnonzero(count[4:] - count[:-4] == 4) + 2
    if len(middle) < FEWEST_BLOCKS * BLOCK:
        return 0.0, float("inf")
    around = middle[:, None] + np.array([-2, -1, 1, 2])
    apart = q[middle] - np.einsum("k,mkj->mj", CUBIC, q[around])
    moved = (q[middle + 2] - q[middle - 2]) / 4.0  # a step; no part of the noise of ``apart``
    due = moved * (late[middle] - late[around] @ CUBIC)[:, None]
    weight = 1.0 / np.maximum(np.mean(apart**2, axis=0), 1e-300)
    product, power = (due * apart) @ weight, (due * due) @ weight
    whole = float(power.sum())
    if whole <= 0.0:
        return 0.0, float("inf")
    share = float(product.sum()) / whole
    starts = np.arange(0, len(middle), BLOCK)
    left = np.add.reduceat(product - share * power, starts)
    return share, float(np.sqrt(np.sum(left**2))) / whole
