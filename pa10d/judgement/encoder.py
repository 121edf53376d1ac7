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
DRAWS = 4  # of the same noise once more: what it makes is then known to a few percent
LEAST_LEFT = 0.1  # of a squared error, of which noise of the angles would make nearly all


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
    level, unlike = density(np.nan_to_num(equation.angles), equation.lowpass.rate)
    most = _share(level, seen, equation) * _rms(modelled, judged)
    if np.all(most <= SLIGHT * _rms(error, judged)):
        return nothing
    shaken = model.sensed(model.contextualise(_shaken(seen, equation, level, SEED)))
    values = _rms(equation.lowpass(shaken) - modelled, judged)
    doubt = 0.5 * float(level @ np.log(unlike)) / max(float(level.sum()), 1e-300)
    return values, doubt * values


def once_more(model: TorqueModel, seen: Context, equation: RunEquation, left: Array) -> list[Array]:
    """(N, n) N·m, some draws: by what the same noise once more on the same motion changes a model's
    torque. None where it can be no more than a slight part of what is left, (n,) N·m RMS."""
    if equation.angles is None:
        return []
    level, _ = density(np.nan_to_num(equation.angles), equation.lowpass.rate)
    torque = model.sensed(seen)
    if np.all(_share(level, seen, equation) * np.sqrt(np.mean(torque**2, axis=0)) <= SLIGHT * left):
        return []
    shaken = (_shaken(seen, equation, level, SEED + k) for k in range(DRAWS))
    return [model.sensed(model.contextualise(one)) - torque for one in shaken]


def less_noise(square: Array, made: Array) -> Array:
    """Of squared errors what is left without what noise of the angles makes of them; a part at
    least, for that is not known so well."""
    return np.maximum(square - made, LEAST_LEFT * square)


def _shaken(seen: Context, equation: RunEquation, level: Array, seed: int) -> Context:
    """The same motion with noise of that level (n,) rad²/Hz once more."""
    low, rate = equation.lowpass, equation.lowpass.rate
    white = np.random.default_rng(seed).standard_normal(seen.q.shape)
    light = Lowpass(len(white), rate, motion_band(rate, low.cutoff))
    q, dq, ddq = light.derivatives(white * np.sqrt(0.5 * rate * level))
    return replace(seen, q=seen.q + q, dq=seen.dq + dq, ddq=seen.ddq + ddq)


def _share(level: Array, seen: Context, equation: RunEquation) -> float:
    """About how much of a torque noise of the angles may be, level (n,) rad²/Hz: of what turns
    masses as much as it is of an acceleration within the equation's band, of what rubs as much as
    of a speed within the motion's."""
    cutoff = equation.lowpass.cutoff
    band = motion_band(equation.lowpass.rate, cutoff)
    speeds = np.sqrt(level * (2.0 * np.pi) ** 2 * band**3 / 3.0)
    turns = np.sqrt(level * (2.0 * np.pi) ** 4 * cutoff**5 / 5.0)
    moved = [np.sqrt(np.mean(x**2, axis=0)) for x in (seen.dq, seen.ddq)]
    shares = [x / np.maximum(m, 1e-300) for x, m in zip((speeds, turns), moved, strict=True)]
    return float(np.max(shares))


def _rms(signals: Array, judged: NDArray[np.bool_]) -> Array:
    """(n,) of signals (M, n), where they count (M, n)."""
    power = np.sum(signals**2, axis=0, where=judged)
    return np.asarray(np.sqrt(power / np.maximum(judged.sum(axis=0), 1)))
