"""Laws that no effect of the library is, on the arm of two links: from physics, sizes at random.

Each takes a generator of random numbers and gives ``extra(t, q, dq, ddq) -> (N, 2)`` N·m.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.signal
from two_links import RATE

Law = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]
SIZE = 0.45  # N·m RMS: about twenty times the noise behind the low-pass


def on(joint: int, torque: np.ndarray) -> np.ndarray:
    """On one joint (0-based), in its usual size."""
    out = np.zeros((len(torque), 2))
    out[:, joint] = SIZE * torque / np.sqrt(np.mean(torque**2))
    return out


def turn(v: np.ndarray) -> np.ndarray:
    return np.tanh(v / 0.02)


def lagged(x: np.ndarray, seconds: float) -> np.ndarray:
    """First-order lag."""
    pole = np.exp(-1.0 / (seconds * RATE))
    return np.asarray(scipy.signal.lfilter([1 - pole], [1, -pole], x))


def play(x: np.ndarray, half: float) -> np.ndarray:
    """A slack: moves along once it is taken up."""
    out, at = np.empty_like(x), x[0]
    for k, value in enumerate(x):
        at = min(max(at, value - half), value + half)
        out[k] = at
    return out


def cable_in_the_elbow(rng) -> Law:
    """Rubbing of a hose that is bent by both joints: three quantities at once."""
    a, b, p = rng.uniform(1.5, 2.5), rng.uniform(1.5, 2.5), rng.uniform(0, 6)
    return lambda t, q, dq, ddq: on(
        0, turn(dq[:, 0]) * np.sin(a * q[:, 0] + p) * np.cos(b * q[:, 1])
    )


def drag_between_joints(rng) -> Law:
    """A damper whose arm of leverage is set by both angles."""
    a, p = rng.uniform(0.8, 1.6), rng.uniform(0, 6)
    return lambda t, q, dq, ddq: on(1, np.sin(a * (q[:, 0] + q[:, 1]) + p) * dq[:, 0] * dq[:, 1])


def grease_that_remembers(rng) -> Law:
    """Sheared grease thins, and sets again within seconds: friction by the speed of the past."""
    s = rng.uniform(0.8, 2.0)

    def extra(t, q, dq, ddq):
        shear = lagged(np.abs(dq[:, 1]), s)
        return on(1, turn(dq[:, 1]) * (shear - shear.mean()))

    return extra


def heat_from_next_door(rng) -> Law:
    """The neighbour's bearing warms this one: viscous friction by what the other did before."""
    s = rng.uniform(1.5, 4.0)

    def extra(t, q, dq, ddq):
        warm = lagged(dq[:, 0] ** 2, s)
        return on(1, dq[:, 1] * (warm - warm.mean()))

    return extra


def seal_that_seizes(rng) -> Law:
    """Late in every run a seal starts to drag, more at one end of the range."""
    at, p = rng.uniform(12, 18), rng.uniform(0, 6)
    return lambda t, q, dq, ddq: on(0, (t > at) * turn(dq[:, 0]) * (1 + np.sin(q[:, 0] + p)))


def harness_with_slack(rng) -> Law:
    """A harness over both joints pulls back once its slack is taken up."""
    half, ratio = rng.uniform(0.3, 0.5), rng.uniform(0.6, 1.4)

    def extra(t, q, dq, ddq):
        x = q[:, 0] + ratio * q[:, 1]
        return on(0, x - play(x, half))

    return extra


def mesh_by_angle(rng) -> Law:
    """A gear rubs with its load, and more where the other joint twists its housing."""
    a, p = rng.uniform(1.5, 2.5), rng.uniform(0, 6)

    def extra(t, q, dq, ddq):
        load = np.sin(q[:, 0] + q[:, 1])
        return on(1, turn(dq[:, 1]) * np.abs(load) * np.sin(a * q[:, 0] + p))

    return extra


def stress_that_relaxes(rng) -> Law:
    """A sheath creeps: a spring of both angles that forgets where it was, stiff by a third."""
    s = rng.uniform(0.8, 2.5)

    def extra(t, q, dq, ddq):
        x = q[:, 0] * q[:, 1]
        return on(0, (x - lagged(x, s)) * np.cos(q[:, 1]))

    return extra


LAWS = (
    cable_in_the_elbow, drag_between_joints, grease_that_remembers, heat_from_next_door,
    seal_that_seizes, harness_with_slack, mesh_by_angle, stress_that_relaxes,
)  # fmt: skip
