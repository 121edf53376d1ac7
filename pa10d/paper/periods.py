"""Periodic motion: the mean period, and the Fourier fit of the motion (paper 2.3, eq. 15)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass
from pa10d.trajectory.fourier import fourier_basis

Array = NDArray[np.float64]

CUTOFF_PER_HARMONIC = 10.0  # products of velocities and cosines reach several times the motion's
# highest harmonic, and friction changes sign within a fraction of a period
CUTOFF_RANGE = (2.0, 40.0)  # Hz
TRACKING = 0.03  # of the acceleration that may lie outside the series before the fit is refused
DRIFT = 3.0  # standard errors by which first and last periods may differ before it is said


@dataclass(frozen=True)
class Averaged:
    """One mean period of a channel.

    t (P,) s within the period; mean (P, n); noise (n,) RMS of one period around the mean, of the
    mean itself it is noise/√periods; drift (n,) RMS difference of the first and the last half of
    the periods; drifts (n,) True where that is more than noise
    """

    t: Array
    mean: Array
    noise: Array
    periods: int
    drift: Array
    drifts: NDArray[np.bool_]

    def warnings(self, channel: str, unit: str) -> list[str]:
        """In words, joints from 1."""
        return [
            f"joint {j + 1}: {channel} drifts over the periods by {self.drift[j]:.3g} {unit} "
            f"beside a noise of {self.noise[j]:.3g} {unit}: averaging hides it; expected a warm "
            "arm or fewer periods"
            for j in np.flatnonzero(self.drifts)
        ]


def average_periods(t: Array, values: Array, fundamental: float, start: float = 0.0) -> Averaged:
    """Mean over all whole periods from ``start`` s on.

    t (N,) s, equidistant; values (N, n); fundamental Hz. Where a period is no whole number of
    samples, a cubic reads the values at the same phases of each.
    """
    rate = (len(t) - 1) / float(t[-1] - t[0])
    period = 1.0 / fundamental
    periods = int(np.floor((t[-1] - start + 1.5 / rate) / period))  # the last sample lasts, too
    if periods < 2:
        raise UserError(
            f"{t[-1] - start:.3g} s are {periods} whole periods of {period:.3g} s; expected at "
            "least 2 to average"
        )
    per = round(rate * period)
    phase = np.arange(per) / per * period
    at = start + phase[None, :] + period * np.arange(periods)[:, None]
    first = round((start - t[0]) * rate)
    exact = abs(rate * period - per) < 1e-6 and abs(t[0] + first / rate - start) < 1e-9
    if exact and first + periods * per <= len(t):
        stack = values[first : first + periods * per].reshape(periods, per, -1)
    else:
        stack = scipy.interpolate.CubicSpline(t, values)(np.clip(at, t[0], t[-1]))
    mean = stack.mean(axis=0)
    deviation = stack - mean
    noise = np.sqrt(np.sum(deviation**2, axis=(0, 1)) / ((periods - 1) * per))
    half = periods // 2
    halves = stack[:half].mean(axis=0) - stack[periods - half :].mean(axis=0)
    # what changes slowly is what counts: noise from sample to sample averages out in a tenth
    width = max(1, per // 10)
    slow = halves[: per // width * width].reshape(-1, width, halves.shape[1]).mean(axis=1)
    drift = np.sqrt(np.mean(slow**2, axis=0))
    expected = noise * np.sqrt(2.0 / half / width)
    return Averaged(phase, mean, noise, periods, drift, drift > DRIFT * expected)


def mean_period(q: Averaged, tau: Averaged, edge: float, name: str) -> Recording:
    """One mean period as a recording that goes on for ``edge`` s at both ends as periodic motion
    does: filters settle there, and what is left in between is the period, once."""
    step = float(q.t[1] - q.t[0])
    around = int(np.ceil(edge / step))
    which = np.arange(-around, len(q.t) + around) % len(q.t)
    t = step * np.arange(float(len(which)))
    return Recording(name, t, q.mean[which], tau.mean[which])


@dataclass(frozen=True)
class FourierMotion:
    """coefficients (1 + 2H, n) [q0, a, b] of equation 13; q, dq, ddq (N, n) of the series;
    position_error (n,) rad RMS of what it leaves; outside (n,) share of the acceleration's RMS
    that the series does not have; trusted (n,) where that is little"""

    coefficients: Array
    q: Array
    dq: Array
    ddq: Array
    position_error: Array
    outside: Array

    @property
    def trusted(self) -> NDArray[np.bool_]:
        """(n,) False where the arm did not follow the series well enough to use it."""
        return np.asarray(self.outside <= TRACKING)

    def warnings(self) -> list[str]:
        """In words, joints from 1."""
        return [
            f"joint {j + 1}: {100 * self.outside[j]:.0f} % of the acceleration lies outside the "
            f"series (RMS position error {self.position_error[j]:.2g} rad): the arm did not follow "
            "closely, the fitted motion would not belong to the measured torque; differentiate the "
            "measured position instead"
            for j in np.flatnonzero(~self.trusted)
        ]


def fourier_motion(
    t: Array, q: Array, fundamental: float, harmonics: int, cutoff: float | None = None
) -> FourierMotion:
    """Least-squares fit (15) of the measured motion q (N, n) rad, and its derivatives (13b, c).

    What the series ignores is measured beside it: the acceleration that differentiating finds
    below ``cutoff`` Hz (default ``suggested_cutoff``).
    """
    b0, b1, b2 = fourier_basis(fundamental, harmonics, t)
    if len(t) < 2 * b0.shape[1]:
        raise UserError(
            f"{len(t)} samples for {b0.shape[1]} coefficients; expected at least {2 * b0.shape[1]}"
        )
    x = np.asarray(np.linalg.lstsq(b0, q, rcond=None)[0], dtype=float)
    left = q - b0 @ x
    rate = (len(t) - 1) / float(t[-1] - t[0])
    limit = min(cutoff or suggested_cutoff(fundamental, harmonics), 0.4 * rate)
    lowpass = Lowpass(len(t), rate, limit)
    inner = slice(min(lowpass.settle, len(t) // 4), -min(lowpass.settle, len(t) // 4) or None)
    missed = lowpass(left, 2)[inner]
    size = np.sqrt(np.mean((b2 @ x)[inner] ** 2, axis=0))
    outside = np.sqrt(np.mean(missed**2, axis=0)) / np.where(size > 0, size, 1.0)
    error = np.sqrt(np.mean(left**2, axis=0))
    return FourierMotion(x, b0 @ x, b1 @ x, b2 @ x, error, np.where(size > 1e-9, outside, 0.0))


def suggested_cutoff(fundamental: float, harmonics: int) -> float:
    """Hz for both sides of the equation, from what the motion was designed to contain."""
    return float(np.clip(CUTOFF_PER_HARMONIC * fundamental * harmonics, *CUTOFF_RANGE))
