"""What usual smoothings do to white noise: the shapes that the spectrum of a torque channel takes.

A drive, a driver or a logger may smooth what it measures: by means over samples, by low-passes, by
polynomials, or by repeating values (whose spectrum is that of a mean). Each leaves less above a
band than within, by as much as its shape says.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.measurement.signals import Lowpass

Array = NDArray[np.float64]
_Kind = tuple[Array, Array, NDArray[np.int64]]  # gains (m, f), knees (m,), numbers within the kind

KIND = 1_000_000  # more than there are smoothings of one kind
FINE = 4  # times as fine as a segment's spectrum
PER_OCTAVE = 24.0  # corners of low-passes: of fourth order the next one is 12 % weaker far above
HIGHEST = 0.45  # of the rate: of a corner
MEAN_OF_TWO = 0.2  # of the rate: at a quarter, Butterworth's first order is a mean of two samples
MEANS_OF_MEANS = 20  # samples of either
LONGEST_POLYNOMIAL = 61  # samples
RESOLVED = 4.0  # ordinates that a window's main lobe takes: closer notches are none
WHITE = (0.0, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)  # of the density at rest: noise from behind the
# smoothing (a converter, rounding)


@dataclass(frozen=True)
class Shapes:
    """m smoothings of white noise of unit density, the first of which is none.

    expected (m, f): ordinates of a segment's periodogram (Hann); passed (m,): Hz, the density
    behind a low-pass, integrated; knee (m,): Hz, from which on it shows what it is, inf where it
    shows wherever one looks; white (m,): part of ``expected`` that was not smoothed;
    prior (m,): sum one; a half that nothing was smoothed, and no kind more likely than another;
    names (k,): of the smoothings, sorted, the same at every length of a segment; place (m,): which
    of them it is, however much white noise there is beside it
    """

    expected: Array
    passed: Array
    knee: Array
    white: Array
    prior: Array
    names: NDArray[np.int64]
    place: NDArray[np.intp]


@lru_cache(maxsize=8)
def shapes(length: int, rate: float, cutoff: float, order: int) -> Shapes:
    """For segments of ``length`` samples at ``rate`` Hz, and a low-pass at ``cutoff`` Hz."""
    f = np.asarray(np.fft.rfftfreq(FINE * length, 1.0 / rate), dtype=np.float64)
    kinds = [_means(length, rate, f), _polynomials(length, f), *_low_passes(length, rate, f)]
    gains = np.concatenate([np.ones((1, len(f))), *(rows for rows, _, _ in kinds)])
    knee = np.concatenate([[np.inf], *(knees for _, knees, _ in kinds)])
    share = 1.0 / len(kinds)
    among = np.concatenate([[0.0], *(np.full(len(k[0]), share / len(k[0])) for k in kinds)])
    seen = _through_window(gains, length)
    low = Lowpass(FINE * length, rate, cutoff, 1, order).gain(f) ** 2 * f[1]
    passed, all_of_it = gains @ low, float(low.sum())
    which = np.append(0, np.tile(np.arange(1, len(gains)), len(WHITE)))
    white = np.append(0.0, np.repeat(WHITE, len(gains) - 1))
    numbers = np.concatenate([[0], *(n + KIND * i for i, (_, _, n) in enumerate(kinds, start=1))])
    names, place = np.unique(numbers[which], return_inverse=True)
    return Shapes(
        expected=seen[which] + white[:, None],
        passed=passed[which] + white * all_of_it,
        knee=knee[which],
        white=white,
        prior=np.where(which > 0, 0.5 * among[which] / len(WHITE), 0.5),
        names=names,
        place=place,
    )


def _through_window(gains: Array, length: int) -> Array:
    """(m, f): what the window of a segment makes of densities (m, FINE·f)."""
    fine = FINE * length
    window = scipy.signal.get_window("hann", length)
    lags = scipy.fft.irfft(np.abs(scipy.fft.rfft(window, fine)) ** 2, fine)
    seen = scipy.fft.rfft(scipy.fft.irfft(gains, fine, axis=1) * (lags / lags[0]), axis=1)
    return np.maximum(seen.real[:, ::FINE], 1e-12)


def _means(length: int, rate: float, f: Array) -> _Kind:
    """Over 2 and more samples, and of such means; repeated values look like a mean."""
    number = np.arange(2, length + 1)
    z = np.pi * f[1:] / rate
    once = np.array([(np.sin(n * z) / (n * np.sin(z))) ** 2 for n in number])
    once = np.column_stack([np.ones(len(once)), once])
    shows = np.where(length / number < RESOLVED, 0.0, np.inf)
    one, other = np.triu_indices(min(len(number), MEANS_OF_MEANS))
    twice = np.maximum(one, other)
    names = np.concatenate([number, KIND // 2 + MEANS_OF_MEANS * one + other])
    return (
        np.concatenate([once, once[one] * once[other]]),
        np.concatenate([shows, shows[twice]]),
        names,
    )


def _polynomials(length: int, f: Array) -> _Kind:
    """Of second and fourth order (Savitzky and Golay), in their middle."""
    size = 2 * (len(f) - 1)
    which = [
        (order, width)
        for order in (2, 4)
        for width in range(order + 3, min(length, LONGEST_POLYNOMIAL) + 1, 2)
    ]
    rows = [
        np.abs(scipy.fft.rfft(scipy.signal.savgol_coeffs(width, order), size)) ** 2
        for order, width in which
    ]
    names = np.array([order * LONGEST_POLYNOMIAL + width for order, width in which])
    return np.array(rows), np.full(len(rows), np.inf), names


def _low_passes(length: int, rate: float, f: Array) -> list[_Kind]:
    """Of first order, once and twice, Butterworth's of first, second and fourth. Far above its
    corner each is alike to all others of its kind."""
    below = np.arange(int(PER_OCTAVE * np.log2(HIGHEST * length)) + 1)
    corner = HIGHEST * rate * 2.0 ** (-below / PER_OCTAVE)
    pole = np.exp(-2.0 * np.pi * corner / rate)[:, None]
    first = np.abs((1.0 - pole) / (1.0 - pole * np.exp(-2j * np.pi * f / rate))) ** 2
    warped = np.tan(np.minimum(np.pi * f / rate, 0.4999 * np.pi))
    ratio = warped / np.tan(np.pi * corner / rate)[:, None]
    butterworth = [1.0 / (1.0 + ratio ** (2 * order)) for order in (1, 2, 4)]
    low = corner < MEAN_OF_TWO * rate
    kinds = [(one, corner, below) for one in (first, first**2, *butterworth[1:])]
    return [*kinds, (butterworth[0][low], corner[low], below[low])]
