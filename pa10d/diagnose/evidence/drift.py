"""How much slower noise may be than a run can show: a sensor that drifts for as long as it records.

The spectrum of noise is averaged over a band, which levels out what rises towards zero within it:
a drift whose memory is as long as the run has nearly all of its power below the first ordinate of
the periodogram, and a constant torque is told from it by nothing but that power.

What a model lacks is slow, too, and is no noise: it goes with the motion. So a drift is sought in
what is left of the slowest ordinates beside all that simple functions of the motion may have there
(restricted likelihood, Patterson and Thompson 1971).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.fft
import scipy.special
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    DRIFT_MEMORIES,
    DRIFT_ORDINATES,
    DRIFT_POWERS,
    DRIFT_SPAN,
    FEWEST_ORDINATES,
    LINE_ABOVE,
)

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Spectrum = NDArray[np.complex128]


@dataclass(frozen=True)
class GoesWithMotion:
    """What the motion may leave in the slowest ordinates of a run's residual, and what that does to
    the likelihood of each law of drift.

    basis (2 K, k): orthonormal, of real and imaginary parts at K ordinates; inner (laws, k, k): the
    inverse of its products under each law; lost (laws,): half the logarithm of their determinant.
    """

    basis: Array
    inner: Array
    lost: Array

    @classmethod
    def of(cls, motion: Array, keep: Mask, length: int) -> GoesWithMotion:
        """motion (M, k): what a residual of M samples may go with, where it counts; length: of the
        transform that the residual is seen through. Of a motion that repeats itself all harmonics
        may be left, whatever its functions are."""
        centre = motion[keep].sum(axis=0) / max(int(keep.sum()), 1)
        seen = np.where(keep[:, None], motion - centre, 0.0)
        columns = slowest(scipy.fft.rfft(seen, length, axis=0), length, len(motion))
        columns = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        harmonic = np.flatnonzero(lines(motion)[: len(columns) // 2])
        harmonic = np.concatenate([harmonic, harmonic + len(columns) // 2])
        u, s, _ = np.linalg.svd(np.hstack([np.eye(len(columns))[:, harmonic], columns]))
        most = max(0, len(columns) - 2 * FEWEST_ORDINATES)
        basis = u[:, : min(most, int(np.sum(s > DRIFT_SPAN * s[0])))] if len(s) else u[:, :0]
        weight = 1.0 / _twice(_laws(len(columns) // 2)[0])
        inner = np.einsum("kp,lk,kq->lpq", basis, weight, basis, optimize=True)
        return cls(basis, np.linalg.inv(inner), 0.5 * np.linalg.slogdet(inner)[1])


def lines(motion: Array) -> Mask:
    """(DRIFT_ORDINATES,) True where one of the first ordinates is a line of the motion (M, k), far
    above both of its neighbours, or a harmonic of what all those lines are harmonics of. The first
    has one neighbour only, and a drift's most: it is never taken for a line."""
    spread = np.maximum(motion.std(axis=0), 1e-300)
    power = np.abs(scipy.fft.rfft((motion - motion.mean(axis=0)) / spread, axis=0)) ** 2
    power = power.sum(axis=1)[1 : DRIFT_ORDINATES + 2]
    above = np.flatnonzero(power[1:-1] > LINE_ABOVE * np.maximum(power[:-2], power[2:])) + 2
    base = int(np.gcd.reduce(above)) if len(above) else 0
    ordinates = np.arange(1, DRIFT_ORDINATES + 1)
    return ordinates % base == 0 if base > 1 else np.isin(ordinates, above)


def slowest(spectrum: Spectrum, length: int, samples: int) -> Array:
    """(2 K, …) real and imaginary parts of the ordinates of ``samples`` samples from the first on,
    as many as tell a drift, out of a longer transform (F, …)."""
    apart = apart_of(length, samples)
    seen = spectrum[apart : apart * (DRIFT_ORDINATES + 1) : apart]
    return np.concatenate([seen.real, seen.imag])


def drift(
    spectrum: Spectrum, length: int, samples: int, moved: GoesWithMotion | None = None
) -> tuple[Array, Array, Array]:
    """(F,) spectrum of noise that may drift, over its level where it is white; which share of the
    power seen goes with no motion, and which would if none did.

    spectrum (F,): transform of ``samples`` samples of noise, padded to ``length``. Drift is an
    Ornstein-Uhlenbeck process. How large it is and how long it remembers is averaged over, each by
    its likelihood (Whittle 1953) and as likely beforehand as none at all.
    """
    slower, apart_from, expected = (np.ones(len(spectrum)) for _ in range(3))
    y = slowest(spectrum, length, samples)
    count = len(y) // 2
    if count < FEWEST_ORDINATES or not np.any(y):
        return slower, apart_from, expected
    shapes, roots, prior = _laws(count)
    weight = 1.0 / _twice(shapes)
    squares, free, lost = weight @ y**2, len(y), np.zeros(len(shapes))
    apart = apart_of(length, samples)
    f = np.arange(min(len(spectrum), apart * (count + 1)))
    if moved is not None and moved.basis.shape[1]:
        along = (weight * y) @ moved.basis
        squares = squares - np.einsum("lp,lpq,lq->l", along, moved.inner, along, optimize=True)
        free, lost = free - moved.basis.shape[1], moved.lost
        near = np.clip(np.round(f / apart).astype(int), 1, count) - 1
        left = y - moved.basis @ (moved.basis.T @ y)
        apart_from[: len(f)] = (_both(left**2) / np.maximum(_both(y**2), 1e-300))[near]
        expected[: len(f)] = 1.0 - 0.5 * _both(np.sum(moved.basis**2, axis=1))[near]
    level = np.maximum(squares, 1e-12 * float(y @ y)) / free
    likelihood = prior - np.sum(np.log(shapes), axis=1) - lost - 0.5 * free * np.log(level)
    share = scipy.special.softmax(likelihood) * level
    slower[: len(f)] += (share @ roots) / share.sum() @ _lorentz(f / apart)
    return slower, apart_from, expected


def apart_of(length: int, samples: int) -> int:
    """Elements of a transform of that length from one ordinate to the next."""
    return max(1, round(length / samples))


def _both(parts: Array) -> Array:
    """(K,) sums of real and imaginary parts (2 K,)."""
    return np.asarray(parts.reshape(2, -1).sum(axis=0))


def _twice(shapes: Array) -> Array:
    return np.concatenate([shapes, shapes], axis=1)


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
