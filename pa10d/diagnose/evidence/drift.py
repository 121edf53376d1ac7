"""How much slower noise may be than a run can show: a sensor that drifts for as long as it records.

The spectrum of noise is averaged over a band, which levels out what rises towards zero within it:
a drift whose memory is as long as the run has nearly all of its power below the first ordinate of
the periodogram, and a constant torque is told from it by nothing but that power. So the spectrum is
averaged relative to one of noise that is white and drifts, and given that one's rise back
(prewhitening, Blackman and Tukey 1958).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy.special
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    DRIFT_MEMORIES,
    DRIFT_ORDINATES,
    DRIFT_POWERS,
    FEWEST_ORDINATES,
)

Array = NDArray[np.float64]


def rise(periodogram: Array, samples: int) -> Array:
    """(F,) spectrum of white noise that may drift, over its level where it is white.

    periodogram (F,): of ``samples`` samples, at F frequencies from zero to half the sampling rate.
    Drift is an Ornstein-Uhlenbeck process. How large it is and how long it remembers is averaged
    over, each by its likelihood (Whittle 1953) and as likely beforehand as none at all.
    """
    out = np.ones(len(periodogram))
    apart = max(1, round(2.0 * (len(periodogram) - 1) / samples))  # as independent ordinates are
    seen = periodogram[apart : apart * (DRIFT_ORDINATES + 1) : apart]
    if len(seen) < FEWEST_ORDINATES or not np.all(seen > 0.0):
        return out
    shapes, roots, prior = _laws(len(seen))
    level = np.mean(seen / shapes, axis=1)
    likelihood = -len(seen) * np.log(level) - np.sum(np.log(shapes), axis=1) + prior
    weight = scipy.special.softmax(likelihood) * level
    drift = (weight[:, None] * roots).sum(axis=0) / weight.sum()
    f = np.arange(min(len(out), apart * (DRIFT_ORDINATES + 1))) / apart
    out[: len(f)] += drift @ _lorentz(f)
    return out


def _lorentz(f: Array) -> Array:
    """(memories, F) of a drift, one at the first ordinate; f in ordinates."""
    corner = (1.0 / (2.0 * np.pi * np.array(DRIFT_MEMORIES)) ** 2)[:, None]
    return np.asarray((1.0 + corner) / (f**2 + corner))


@lru_cache(maxsize=8)
def _laws(count: int) -> tuple[Array, Array, Array]:
    """(laws, count) spectra at the ordinates, (laws, memories) power of each drift at the first of
    them, (laws,) logarithm of how likely each is beforehand. The first law is without drift."""
    ordinates = np.arange(1.0, count + 1.0)
    powers = np.array(DRIFT_POWERS)
    each = np.einsum("p,mn->pmn", powers, np.eye(len(DRIFT_MEMORIES)))
    roots = np.vstack([np.zeros(len(DRIFT_MEMORIES)), each.reshape(-1, len(DRIFT_MEMORIES))])
    prior = np.full(len(roots), -np.log(2.0 * (len(roots) - 1)))
    prior[0] = -np.log(2.0)
    return 1.0 + roots @ _lorentz(ordinates), roots, prior
