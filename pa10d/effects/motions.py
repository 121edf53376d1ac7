"""Motions on which an effect's signature is drawn: short, and telling for a kind of effect."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot

Array = NDArray[np.float64]

POSE = (0.2, 0.5, 0.1, 0.7, 0.2, 0.6, 0.1)  # rad, where joints rest; repeated for longer arms


@dataclass(frozen=True)
class ShownMotion:
    """t (N,) s; q, dq, ddq (N, n); what it is in words; frequency (N,) Hz where it has one."""

    t: Array
    q: Array
    dq: Array
    ddq: Array
    text: str
    frequency: Array | None = None


def motion(name: str, robot: Robot, joint: int) -> ShownMotion:
    """One of MOTIONS by name; joint: 0-based, the one that moves where only one does."""
    return MOTIONS[name](robot, joint)


def _swing(robot: Robot, j: int) -> ShownMotion:
    t = _times(12.0)
    angle = 0.5 + 0.6 * np.sin(2 * np.pi * t / 6.0)
    return _one_moves(robot, j, t, angle, f"joint {j + 1} swings to and fro, the others rest")


def _reversals(robot: Robot, j: int) -> ShownMotion:
    t = _times(15.0)
    size = np.interp(t, [0.0, 15.0], [0.03, 0.003])
    angle = 0.5 + size * np.sin(2 * np.pi * t / 3.0)
    text = f"joint {j + 1} makes small to-and-fro motions, each smaller than the one before"
    return _one_moves(robot, j, t, angle, text)


def _across_upright(robot: Robot, j: int) -> ShownMotion:
    t = _times(12.0)
    angle = 0.25 * np.sin(2 * np.pi * t / 6.0)
    text = f"joint {j + 1} swings slowly through the upright pose, where gravity changes sides"
    return _one_moves(robot, j, t, angle, text, pose=(0.0,))


def _chirp(robot: Robot, j: int) -> ShownMotion:
    t = _times(9.0)
    frequency = np.interp(t, [0.0, 9.0], [0.5, 5.0])
    phase = 2 * np.pi * np.cumsum(frequency) * (t[1] - t[0])
    angle = 0.5 + 2.0 / (2 * np.pi * frequency) ** 2 * np.sin(phase)
    text = f"joint {j + 1} moves to and fro with rising frequency, equally hard all the time"
    return _one_moves(robot, j, t, angle, text, frequency)


def _warm_up(robot: Robot, j: int) -> ShownMotion:
    t = _times(600.0, rate=25.0)
    angle = 0.5 + 1.2 * np.sin(2 * np.pi * t / 40.0)
    return _one_moves(robot, j, t, angle, f"joint {j + 1} swings evenly for ten minutes")


def _wander(robot: Robot, j: int) -> ShownMotion:
    t = _times(20.0)
    numbers = np.arange(1, robot.n + 1)
    first = np.sin(2 * np.pi * (0.07 + 0.013 * numbers) * t[:, None] + numbers)
    second = np.sin(2 * np.pi * (0.17 + 0.021 * numbers) * t[:, None] + 2.0 * numbers)
    return _differentiated(t, _pose(robot, POSE) + 0.6 * first + 0.25 * second, "all joints move")


MOTIONS: dict[str, Callable[[Robot, int], ShownMotion]] = {
    "swing": _swing,
    "reversals": _reversals,
    "across_upright": _across_upright,
    "chirp": _chirp,
    "warm_up": _warm_up,
    "wander": _wander,
}


def _times(seconds: float, rate: float = 500.0) -> Array:
    return np.arange(int(seconds * rate)) / rate


def _pose(robot: Robot, pattern: tuple[float, ...]) -> Array:
    return np.resize(np.array(pattern), robot.n)


def _one_moves(
    robot: Robot,
    joint: int,
    t: Array,
    angle: Array,
    text: str,
    frequency: Array | None = None,
    pose: tuple[float, ...] = POSE,
) -> ShownMotion:
    q = np.tile(_pose(robot, pose), (len(t), 1))
    q[:, joint] = angle
    return _differentiated(t, q, text, frequency)


def _differentiated(t: Array, q: Array, text: str, frequency: Array | None = None) -> ShownMotion:
    """Differences are good enough for a picture; the ends, where they are not, are cut off."""
    dq = np.gradient(q, t, axis=0)
    ddq = np.gradient(dq, t, axis=0)
    inner = slice(3, -3)
    kept = None if frequency is None else frequency[inner]
    return ShownMotion(t[inner] - t[3], q[inner], dq[inner], ddq[inner], text, kept)
