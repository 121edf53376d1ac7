"""How noisy an encoder is, and up to which frequency motion makes a torque's slope, and not noise.

Steps and noise of an encoder have a flat spectrum, which is seen alone far above the motion. In a
third derivative, which a delay of a torque of inertia is seen by, it grows with the sixth power of
frequency. A servo answers noise as it answers motion, with a delay of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

Array = NDArray[np.float64]

SECONDS = 4.0  # of one segment
LONGEST = 60_000  # samples of a run that are looked at
ALONE = (0.12, 0.2)  # of the sampling rate, where nothing of the motion is left, and what is
HIGHEST = (60.0, 96.0)  # Hz at most: a light low-pass of the motion leaves it as it was
ABOVE = 10.0  # times the noise: what is less is not all motion
SHARE = 1e-3  # of the motion's third derivative (power), that noise may add
PARTS = (0.12, 0.2, 0.3, 0.45)  # of the sampling rate: edges of the parts where noise is looked at
SHORT = 2.0  # s of one segment there


def motion_up_to(runs: Sequence[tuple[Array, float]]) -> float:
    """Hz, of most joints: runs are angles (N, n) and their rate, no joint's noise being more than
    ``SHARE`` below; inf where there is none to be seen."""
    powers = zip(*(_powers(q, rate) for q, rate in runs), strict=True)
    made, noise = (np.asarray(sum(of_runs)) for of_runs in powers)
    moves = made > 0.0
    if not moves.any():
        return np.inf
    with np.errstate(divide="ignore"):
        highest = (7.0 * SHARE * made[moves] / ((2.0 * np.pi) ** 6 * noise[moves])) ** (1.0 / 7.0)
    return float(np.median(highest))


def density(q: Array, rate: float) -> tuple[Array, Array]:
    """(n,) rad²/Hz (one-sided) of the noise of measured angles (N, n), the least that three parts
    of the spectrum far above the motion show, and (n,) how many times more the most is (1: none).

    Seen in second differences: through the window of a spectrum so much of the motion leaks to the
    far end that it would be taken for the noise of a fine encoder. A jump counts in its stretch
    alone, of which the median knows nothing."""
    twice = np.diff(q, 2, axis=0)
    length = min(len(twice), int(SHORT * rate))
    f, power = scipy.signal.welch(twice, rate, nperseg=length, axis=0, average="median")
    gain = (2.0 * np.sin(np.pi * f / rate)) ** 4
    parts = []
    for low, high in pairwise(PARTS):
        there = (f >= low * rate) & (f < high * rate)
        parts.append(np.median(power[there] / gain[there, None], axis=0))
    least, most = np.min(parts, axis=0), np.max(parts, axis=0)
    return least, np.divide(most, least, out=np.ones_like(least), where=least > 0.0)


def _powers(q: Array, rate: float) -> tuple[Array, Array]:
    """(n,) power of the motion's third derivative, rad²/s⁶, and (n,) density of the noise, rad²/Hz,
    both times the duration."""
    spare = max(0, len(q) - LONGEST) // 2
    part = q[spare : len(q) - spare]
    f, power = scipy.signal.welch(part, rate, nperseg=min(len(part), int(SECONDS * rate)), axis=0)
    low, high = (min(a * rate, b) for a, b in zip(ALONE, HIGHEST, strict=True))
    noise = np.median(power[(f > low) & (f < high)], axis=0)
    motion = np.where((power > ABOVE * noise) & (f[:, None] < low), power, 0.0)
    made = (2.0 * np.pi * f) ** 6 @ motion * f[1]
    return made * len(q) / rate, noise * len(q) / rate
