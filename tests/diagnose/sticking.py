"""Two links that truly stick: each time a joint turns round it stands for some 10 to 60 ms while
its friction goes from one breakaway to the other."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from two_links import NAMES, ROTOR, robot

from pa10d.dynamics import inverse_dynamics
from pa10d.measurement.recording import Recording

RATE, SECONDS = 500.0, 30.0
COULOMB, VISCOUS = np.array([20.0, 10.0]), np.array([3.0, 1.5])
STICKS_BELOW = 0.03  # rad/s of what would be its speed if it never stuck


def motion(seed: int):
    """t (N,), q, q̇, q̈ (N, 2), way (N, 2) from one breakaway (-1) to the other (+1), stands (N, 2):
    sums of sines whose velocity x is drawn in towards zero, sign(x)·y²/(y + d), y = |x| - d ≥ 0."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(RATE * SECONDS)) / RATE
    w = 2 * np.pi * rng.uniform(0.08, 0.9, (6, 2))
    a = rng.uniform(0.2, 0.5, (6, 2)) / w**0.5
    angle = w[None] * t[:, None, None] + rng.uniform(0, 2 * np.pi, (6, 2))
    free, slope = (a * w * np.cos(angle)).sum(axis=1), -(a * w**2 * np.sin(angle)).sum(axis=1)
    d, y = STICKS_BELOW, np.maximum(np.abs(free) - STICKS_BELOW, 0.0)
    dq, ddq = np.sign(free) * y**2 / (y + d), y * (y + 2 * d) / (y + d) ** 2 * slope
    # Euler and Maclaurin: the trapezoids' sum less a twelfth of the slopes' differences
    steps = (dq[1:] + dq[:-1]) / 2 / RATE - np.diff(ddq, axis=0) / 12 / RATE**2
    q = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    return t, q - q.mean(axis=0), dq, ddq, free / d, y <= 0


def sticking_runs(
    seed: int, noise: float, extra: Callable[[np.ndarray], np.ndarray] | None = None
) -> dict[str, Recording]:
    """Four runs; extra: (N,) rad/s of joint 1 -> N·m of further friction there while it moves."""
    out = {}
    for number, name in enumerate(NAMES):
        rng = np.random.default_rng([seed, number, 9])
        t, q, dq, ddq, way, stands = motion(100 * seed + number)
        tau = inverse_dynamics(robot(), robot().parameters, q, dq, ddq) + ROTOR * ddq
        tau += VISCOUS * dq + COULOMB * np.where(stands, way, np.sign(dq))
        if extra is not None:
            tau[:, 0] += np.where(stands[:, 0], 0.0, extra(dq[:, 0]))
        out[name] = Recording(name, t, q, tau + noise * rng.standard_normal(tau.shape))
    return out
