"""Can a motion be run as it stands? Every violation is one sentence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import of_a_slide
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.trajectory.capsules import Capsules, capsules_of
from pa10d.trajectory.limits import MotionLimits
from pa10d.trajectory.motions import MotionSamples
from pa10d.trajectory.plan import Plan

Array = NDArray[np.float64]

RATE = 200.0  # Hz at which a plan is looked at
CLOSE = 0.02  # m between bodies that must be kept
ROUNDING = 1e-6
JUMP = 0.02  # of the speed limit, that a step may differ from what the speeds say


@dataclass(frozen=True)
class Violation:
    """joint (1-based, 0 for the whole arm), time s, what was found and what is allowed."""

    kind: str
    joint: int
    time: float
    value: float
    limit: float
    sentence: str


def check(
    plan: Plan | MotionSamples,
    robot: Robot,
    limits: MotionLimits,
    measured: Array | None = None,
    torque: Callable[[MotionSamples], Array] | None = None,
) -> list[Violation]:
    """The worst violation of each kind and joint; an empty list means: go.

    limits: of the robot itself, not those of planning.
    measured: (n,) where the arm stands, to be compared with the start. torque: what predicts N·m
    (N, n) for the motion; default: rigid bodies of the URDF, without friction.
    """
    samples = plan.sample(RATE) if isinstance(plan, Plan) else plan
    if samples.q.shape[1] != robot.n:
        words = f"the plan moves {samples.q.shape[1]} joints, the robot has {robot.n}"
        return [Violation("shape", 0, 0.0, samples.q.shape[1], robot.n, words)]
    for name, values in zip(("position", "speed", "acceleration"), samples[1:], strict=True):
        if not np.isfinite(values).all():
            row, j = (int(k) for k in np.argwhere(~np.isfinite(values))[0])
            words = f"joint {j + 1} at {samples.t[row]:.2f} s: {name} is not a number"
            return [Violation("number", j + 1, float(samples.t[row]), np.nan, np.nan, words)]
    tau = torque(samples) if torque else _rigid(robot, samples)
    found = [
        *_position(samples, limits),
        *_above("velocity", "speed", "rad/s", samples, samples.dq, limits.velocity),
        *_above(
            "acceleration", "acceleration", "rad/s²", samples, samples.ddq, limits.acceleration
        ),
        *_above("torque", "torque", "N·m", samples, tau, limits.torque),
        *_steps(samples, limits),
        *_ends(samples, limits, measured),
        *_bodies(samples, capsules_of(robot)),
    ]
    slides = {int(j) + 1 for j in np.flatnonzero(robot.prismatic)}
    return [
        replace(one, sentence=of_a_slide(one.sentence)) if one.joint in slides else one
        for one in found
    ]


def _rigid(robot: Robot, s: MotionSamples) -> Array:
    return inverse_dynamics(robot, robot.parameters, s.q, s.dq, s.ddq)


def _position(s: MotionSamples, limits: MotionLimits) -> list[Violation]:
    """Where each joint would come to rest if it braked now: it must not lie beyond a limit."""
    stop = s.q + s.dq * np.abs(s.dq) / (2 * limits.acceleration)
    found = []
    for side, beyond, limit in (
        ("lower", limits.lower - stop, limits.lower),
        ("upper", stop - limits.upper, limits.upper),
    ):
        for j in np.flatnonzero(beyond.max(axis=0) > ROUNDING):
            k = int(np.argmax(beyond[:, j]))
            value, when = float(stop[k, j]), float(s.t[k])
            how = f"{value:.3f} rad" + (
                "" if abs(s.dq[k, j]) < 1e-3 else f" (at {s.q[k, j]:.3f} rad, braking included)"
            )
            words = (
                f"joint {j + 1} at {when:.2f} s: position {how} is beyond its {side} limit of "
                f"{limit[j]:.3f} rad"
            )
            found.append(Violation("position", int(j) + 1, when, value, float(limit[j]), words))
    return found


def _above(
    kind: str, word: str, unit: str, s: MotionSamples, values: Array, limit: Array
) -> list[Violation]:
    found = []
    for j in np.flatnonzero(np.abs(values).max(axis=0) > limit * (1 + ROUNDING)):
        k = int(np.argmax(np.abs(values[:, j])))
        value, when = float(values[k, j]), float(s.t[k])
        words = (
            f"joint {j + 1} at {when:.2f} s: {word} {value:.4g} {unit} exceeds its limit of "
            f"{limit[j]:.4g} {unit}"
        )
        found.append(Violation(kind, int(j) + 1, when, value, float(limit[j]), words))
    return found


def _steps(s: MotionSamples, limits: MotionLimits) -> list[Violation]:
    """Positions that jump: a plan that was put together wrongly."""
    dt = np.diff(s.t)[:, None]
    off = np.abs(np.diff(s.q, axis=0) - 0.5 * (s.dq[1:] + s.dq[:-1]) * dt)
    allowed = JUMP * limits.velocity * dt + limits.acceleration * dt**2
    found = []
    for j in np.flatnonzero((off > allowed).any(axis=0)):
        k = int(np.argmax(off[:, j]))
        value, limit, when = float(off[k, j]), float(allowed[k, j]), float(s.t[k])
        words = f"joint {j + 1} at {when:.2f} s: position jumps by {value:.4f} rad, expected none"
        found.append(Violation("step", int(j) + 1, when, value, limit, words))
    return found


def _ends(s: MotionSamples, limits: MotionLimits, measured: Array | None) -> list[Violation]:
    found = []
    for row, word in ((0, "begins"), (-1, "ends")):
        for j in np.flatnonzero(np.abs(s.dq[row]) > 1e-3 * limits.velocity):
            value, when = float(s.dq[row, j]), float(s.t[row])
            where = f"joint {j + 1} at {when:.2f} s"
            words = f"{where}: the motion {word} at {value:.3f} rad/s, not at rest"
            found.append(Violation("rest", int(j) + 1, when, value, 0.0, words))
    if measured is None:
        return found
    for j in np.flatnonzero(np.abs(measured - s.q[0]) > 0.01):
        value, limit = float(measured[j]), float(s.q[0, j])
        words = (
            f"joint {j + 1} at 0.00 s: the arm stands at {value:.3f} rad, the motion begins at "
            f"{limit:.3f} rad"
        )
        found.append(Violation("start", int(j) + 1, 0.0, value, limit, words))
    return found


def _bodies(s: MotionSamples, capsules: Capsules) -> list[Violation]:
    gaps = capsules.clearance(s.q)
    found = []
    for column in np.flatnonzero(gaps.min(axis=0) < CLOSE) if gaps.size else ():
        k = int(np.argmin(gaps[:, column]))
        value, when = float(gaps[k, column]), float(s.t[k])
        state = (
            f"{1e3 * value:.0f} mm apart"
            if value >= 0
            else f"{-1e3 * value:.0f} mm into each other"
        )
        words = (
            f"at {when:.2f} s: {capsules.name(int(column))} are {state}, expected at least "
            f"{1e3 * CLOSE:.0f} mm between them"
        )
        found.append(Violation("collision", 0, when, value, CLOSE, words))
    return found
