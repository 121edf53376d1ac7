"""What noise of the angles leaves of the torque within the band of the fit.

An encoder's steps and noise have a flat spectrum, which is seen alone far above the motion. Two
derivatives and an arm's inertia make a torque of it that no model foretells. Above the band it has
grown with the fourth power of frequency, so no spectrum up there says how much of it is within;
but a model of the arm does: the same noise once more on the same motion, and what that changes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.effects import Context
from pa10d.measurement.encoder_noise import density
from pa10d.measurement.signals import Lowpass
from pa10d.model import TorqueModel
from pa10d.regression.equation import RunEquation, motion_band

Array = NDArray[np.float64]

SLIGHT = 0.1  # of a torque's error: what can be no more is not worked out
SEED = 1


def of_angles(
    model: TorqueModel,
    seen: Context,
    equation: RunEquation,
    modelled: Array,
    error: Array,
    judged: NDArray[np.bool_],
) -> tuple[Array, Array]:
    """(n,) N·m RMS over the samples by which each joint is judged (M, n), 0 where it is next to
    nothing; and standard errors, as far as the noise is not as white as it was taken to be.

    seen: the run's motion as the model sees it; modelled: its torque, which leaves error, each
    (M, n) N·m."""
    n = error.shape[1]
    nothing = np.zeros(n), np.zeros(n)
    if equation.angles is None:
        return nothing
    low, rate = equation.lowpass, equation.lowpass.rate
    level, unlike = density(np.nan_to_num(equation.angles), rate)
    most = _at_most(level, low.cutoff, seen.ddq, _rms(modelled, judged))
    if np.all(most <= SLIGHT * _rms(error, judged)):
        return nothing
    light = Lowpass(len(seen.q), rate, motion_band(rate, low.cutoff))
    white = np.random.default_rng(SEED).standard_normal(seen.q.shape)
    q, dq, ddq = light.derivatives(white * np.sqrt(0.5 * rate * level))
    shaken = replace(seen, q=seen.q + q, dq=seen.dq + dq, ddq=seen.ddq + ddq)
    values = _rms(low(model.sensed(model.contextualise(shaken))) - modelled, judged)
    doubt = 0.5 * float(np.max(np.log(unlike), where=level > 0.0, initial=0.0))
    return values, doubt * values


def _at_most(level: Array, cutoff: float, ddq: Array, torque: Array) -> Array:
    """(n,) N·m, were it inertia alone that made torques as large (n,) with accelerations (N, n) as
    large. level (n,) rad²/Hz, white up to the cut-off."""
    noise = np.sqrt(level * (2.0 * np.pi) ** 4 * cutoff**5 / 5.0)  # rad/s²
    share = noise / np.maximum(np.sqrt(np.mean(ddq**2, axis=0)), 1e-300)
    return np.asarray(float(share.max()) * torque)


def _rms(signals: Array, judged: NDArray[np.bool_]) -> Array:
    """(n,) of signals (M, n), where they count (M, n)."""
    power = np.sum(signals**2, axis=0, where=judged)
    return np.asarray(np.sqrt(power / np.maximum(judged.sum(axis=0), 1)))
