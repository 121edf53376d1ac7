"""Position, velocity and acceleration of a run, lightly filtered, from the better of two sources.

Differentiating the angle is right for a clean log. Where stamps are the logger's rather than the
robot's, an angle is wrong by speed × jitter, and two derivatives make of a millisecond a torque;
a velocity that the robot itself reported is wrong by acceleration × jitter only. It is taken,
joint by joint, where it agrees with the angle, the two differ enough to matter, and it is the
quieter one above the band of the equation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass, delayed

Array = NDArray[np.float64]

MATTERS = 0.01  # of the acceleration: differences between the sources below this are ignored
AGREES = 0.1  # of the velocity, after the lag is taken out
GAIN = 0.03  # by which slopes may differ: a velocity in other units is none
QUIETER = 0.7  # ratio of what lies above the equation's band
STANDS = 1e-6  # of the largest acceleration of any joint: less is rounding
FARTHEST = 0.05  # s of lag, beyond which the two are not the same quantity

SEGMENT = 4.0  # s of one segment of an acceleration's spectrum
LONGEST = 60_000  # samples of a run that are looked at
BANDS_PER_OCTAVE = 3.0  # over which a spectrum is averaged


@dataclass(frozen=True)
class Quieting:
    """Takes from signals (N, n), of whose joints each has noise of its own above ``up_to`` (n,) Hz
    (inf: none is seen), what lies beyond. rate: of the samples, Hz."""

    up_to: tuple[float, ...]

    def __call__(self, signal: Array, rate: float) -> Array:
        quiet = signal.copy()
        for j, highest in enumerate(self.up_to):
            if highest < 0.5 * rate:
                quiet[:, j] = Lowpass(len(signal), rate, highest)(signal[:, j])
        return quiet


@dataclass(frozen=True)
class VelocitySource:
    """reported (n,): True where the reported velocity is used; lag: s by which it is late."""

    reported: NDArray[np.bool_]
    lag: float = 0.0


def motion(
    recording: Recording, light: Lowpass, source: VelocitySource
) -> tuple[Array, Array, Array]:
    """q, q̇, q̈ (N, n) behind the light low-pass."""
    q, dq, ddq = light.derivatives(recording.q)
    if source.reported.any() and recording.dq is not None:
        chosen = source.reported
        there = delayed(recording.dq[:, chosen], -source.lag, recording.rate)
        dq[:, chosen], ddq[:, chosen] = light.rates(there)
    return q, dq, ddq


def velocity_source(recording: Recording, cutoff: float) -> VelocitySource:
    """Which velocities to trust for an equation that is cut off at ``cutoff`` Hz."""
    n = recording.joints
    if recording.dq is None or not np.isfinite(recording.dq).all():
        return VelocitySource(np.zeros(n, dtype=bool))
    band = Lowpass(len(recording.t), recording.rate, cutoff)
    wide = Lowpass(len(recording.t), recording.rate, min(4.0 * cutoff, 0.4 * recording.rate))
    _, own, own_slope = band.derivatives(recording.q)
    inner = slice(band.settle, -band.settle)
    reported, reported_slope = band.rates(recording.dq)
    lag = _lag(reported[inner] - own[inner], own_slope[inner])
    if abs(lag) > FARTHEST:
        return VelocitySource(np.zeros(n, dtype=bool))
    moved = delayed(recording.dq, -lag, recording.rate)
    reported, reported_slope = band.rates(moved)
    speed, pace = _rms(own[inner]), _rms(own_slope[inner])
    alike = _rms(reported[inner] - own[inner]) < AGREES * speed
    slope = np.sum(reported[inner] * own[inner], axis=0) / np.maximum(
        np.sum(own[inner] ** 2, axis=0), 1e-300
    )
    matters = _rms(reported_slope[inner] - own_slope[inner]) > MATTERS * pace
    above_own = wide(recording.q, 1)[inner] - own[inner]
    above_reported = wide(moved)[inner] - reported[inner]
    quieter = _rms(above_reported) < QUIETER * _rms(above_own)
    return VelocitySource(alike & (np.abs(slope - 1) < GAIN) & matters & quieter, lag)


def quieting_of(ddq: Array, rate: float, lowest: float, highest: float) -> Quieting | None:
    """What takes the noise from an acceleration (N, n); None where none is seen."""
    up_to = motion_bands(ddq, rate, lowest, highest)
    return Quieting(up_to) if np.isfinite(up_to).any() else None


def motion_bands(ddq: Array, rate: float, lowest: float, highest: float) -> tuple[float, ...]:
    """(n,) Hz up to which an acceleration (N, n) is the joint's motion; inf where no end is seen.

    What moves a joint falls off with frequency; noise of an angle grows with the fourth power of it
    in the acceleration. So motion ends in the valley of the spectrum between ``lowest``, below
    which nothing is given up, and ``highest``, to which the acceleration was filtered. Whatever
    else grows again beyond a valley (a drive that hums, stamps that are interpolated) is no torque
    that rigid links pass on either.
    """
    octaves = np.log2(highest / lowest) if highest > lowest else 0.0
    if octaves < 2.0 / BANDS_PER_OCTAVE:
        return (np.inf,) * ddq.shape[1]
    spare = max(0, len(ddq) - LONGEST) // 2
    part = ddq[spare : len(ddq) - spare]
    length = min(len(part), int(SEGMENT * rate))
    f, power = scipy.signal.welch(part, rate, nperseg=length, axis=0)
    edges = lowest * 2.0 ** (np.arange(int(octaves * BANDS_PER_OCTAVE) + 1) / BANDS_PER_OCTAVE)
    within = np.digitize(f, edges) - 1
    seen = [k for k in range(len(edges) - 1) if np.any(within == k)]
    if len(seen) < 2:
        return (np.inf,) * ddq.shape[1]
    density = np.array([power[within == k].mean(axis=0) for k in seen])
    valley = density.argmin(axis=0)
    return tuple(np.inf if v == len(seen) - 1 else float(edges[seen[v] + 1]) for v in valley)


def _lag(difference: Array, acceleration: Array) -> float:
    """Seconds by which a velocity is late: what difference and acceleration have in common,
    joints weighted alike; 0 where none moves, and what one that stands measures is noise."""
    size = _rms(acceleration)
    moves = size > STANDS * size.max(initial=0.0)
    if not moves.any():
        return 0.0
    unit, apart = acceleration[:, moves] / size[moves], difference[:, moves] / size[moves]
    return float(np.median(-np.sum(apart * unit, axis=0) / np.sum(unit**2, axis=0)))


def _rms(x: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))
