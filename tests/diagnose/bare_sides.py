"""Sides without a robot behind them: numbers in, to check the statistics alone."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from scipy.signal import lfilter

from pa10d.diagnose.regression.side import PerJoint, Side
from pa10d.measurement.signals import Lowpass
from pa10d.regression.equation import RunEquation

RATE = 50.0


def bare_side(tau: list[np.ndarray], keep: list[np.ndarray] | None = None) -> Side:
    """One run per array (M, n) of torque."""
    runs = []
    for index, values in enumerate(tau):
        lowpass = Lowpass(len(values), RATE, 0.2 * RATE)
        kept = np.ones(values.shape, dtype=bool) if keep is None else keep[index]
        still = SimpleNamespace(q=np.zeros(values.shape), dq=np.zeros(values.shape))
        runs.append(RunEquation(f"run{index}", still, lowpass, values, kept, values))  # type: ignore[arg-type]
    return Side.of(runs)


def ar1(rng: np.random.Generator, samples: int, phi: float) -> np.ndarray:
    """(samples,) of an AR(1) process of unit variance in its stationary state."""
    drive = rng.standard_normal(samples)
    drive[1:] *= np.sqrt(1.0 - phi**2)
    return np.asarray(lfilter([1.0], [1.0, -phi], drive))


def smooth_signal(rng: np.random.Generator, samples: int) -> np.ndarray:
    """(samples,): a few slow sines, like a column of a motion."""
    t = np.arange(samples) / RATE
    f = rng.uniform(0.05, 1.5, 6)
    phase = rng.uniform(0, 2 * np.pi, 6)
    return np.asarray(np.sin(2 * np.pi * np.outer(t, f) + phase).sum(axis=1) / np.sqrt(3.0))


def stacked(rows: PerJoint) -> np.ndarray:
    """All joints' rows one after the other."""
    return np.concatenate([rows[j] for j in sorted(rows)])


def limits(*bounds: tuple[float, float]) -> SimpleNamespace:
    """As much of an effect as its coefficients' bounds."""
    return SimpleNamespace(coefficients=[SimpleNamespace(lower=a, upper=b) for a, b in bounds])
