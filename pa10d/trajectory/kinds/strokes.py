"""Constant-speed strokes of one joint: what sweeps are made of."""

from __future__ import annotations

import numpy as np

from pa10d.trajectory.kinds.base import Array
from pa10d.trajectory.motions import Drawing, ramp_time
from pa10d.trajectory.plan import Segment

RAMP_SHARE = 0.7  # of the acceleration limit while the speed is reached
TURN = 0.15  # s at rest before and after a stroke


def stroke(
    pose: Array, joint: int, begin: float, speed: float, seconds: float, limit: float, label: str
) -> Segment:
    """From rest at ``begin`` rad at constant signed ``speed`` rad/s for ``seconds``, to rest.

    limit: rad/s² of the joint; the window is the part at constant speed.
    """
    start = np.array(pose, dtype=float)
    start[joint] = begin
    velocity = np.zeros(len(pose))
    velocity[joint] = speed
    drawing = Drawing(start)
    drawing.rest(TURN)
    ramp = max(ramp_time(np.array([speed]), np.array([RAMP_SHARE * limit])), 0.02)
    window = drawing.cruise(velocity, seconds, ramp)
    drawing.rest(TURN)
    return Segment(drawing.knots(*window), label)


def to_and_fro(
    pose: Array,
    joint: int,
    span: tuple[float, float],
    speed: float,
    longest: float,
    limit: float,
    label: str,
) -> list[Segment]:
    """Both directions at one speed, over the whole ``span`` (rad), or as much of its middle as
    ``longest`` s allow."""
    ramp = max(ramp_time(np.array([speed]), np.array([RAMP_SHARE * limit])), 0.02)
    room = span[1] - span[0]
    seconds = min(longest, room / speed - ramp)
    travel = speed * (seconds + ramp)
    begin = 0.5 * (span[0] + span[1]) - 0.5 * travel
    return [
        stroke(pose, joint, begin, speed, seconds, limit, f"{label} +{speed:.4g} rad/s"),
        stroke(pose, joint, begin + travel, -speed, seconds, limit, f"{label} -{speed:.4g} rad/s"),
    ]


def fastest(span: tuple[float, float], velocity: float, limit: float, steady: float) -> float:
    """The highest speed, rad/s up to ``velocity``, that a span leaves ``steady`` s of."""
    room = span[1] - span[0]
    # room = v·steady + v·ramp, ramp = 1.5·v/limit
    slope = 1.5 / (RAMP_SHARE * limit)
    possible = (-steady + np.sqrt(steady**2 + 4 * slope * room)) / (2 * slope)
    return float(min(velocity, possible))
