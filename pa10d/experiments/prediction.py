"""How well a joint servo will follow a motion, before anything moves.

The servo has to give what is not given ahead: gravity, coupling, and friction and inertia where
they were not measured. With J·ë + (kd + B)·ė + (kp - G)·e + ki·∫e = that torque, each joint for
itself, the error follows from the motion alone: G is what gravity pulls a joint further away by, in
the mean over the motion, a spring between motor and link is part of the joint. Delay is left out,
margins (``servo_design``) allow for it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.control.gains import PidGains
from pa10d.control.joint_figures import JointFigures, inertias
from pa10d.control.limits import ArmLimits
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.dynamics.mass import mass_matrices
from pa10d.experiments.shaking import torque_ahead
from pa10d.experiments.slower import SLOWEST
from pa10d.experiments.wound_springs import LOSS, behind_spring, filtered, links_along, links_of
from pa10d.trajectory.motions import MotionSamples

Array = NDArray[np.float64]

DOUBT = 2.0  # times the predicted error: as large it was seen, on arms their URDF describes badly
FAST, STRONG = 1.12, 0.95  # of the limits of speed and torque
LOOKED_AT = ("error", "swing", "speed", "torque", "beyond")
PACES = (1.0, 1.25, 1.6, 2.0, 2.5, 3.2, SLOWEST)  # times as long, tried in turn


@dataclass(frozen=True)
class Predicted:
    """(n,) each: largest tracking error rad, speed rad/s, torque N·m; how far a link swings on its
    spring about where it would be if the motion were slow, rad; how far beyond a position limit a
    joint would stop, rad, with ``DOUBT`` times the error: negative where it is clear."""

    error: Array
    swing: Array
    speed: Array
    torque: Array
    beyond: Array

    def problem(self, limits: ArmLimits) -> str:
        """What would end the motion, in words; empty where nothing does."""
        for values, most, words in self._looks(limits):
            over = values / most
            if (over > 1.0).any():
                j = int(np.argmax(over))
                return limits.in_units(j, f"joint {j + 1}{words.format(values[j])}")
        return ""

    def over(self, limits: ArmLimits) -> Array:
        """(n,) of what each joint may: more than 1 would end the motion."""
        return np.max([values / most for values, most, _ in self._looks(limits)], axis=0)

    def _looks(self, limits: ArmLimits) -> tuple[tuple[Array, Array, str], ...]:
        return (
            (self.error, limits.following_error / DOUBT, " would be {:.2g} rad from its path"),
            (self.swing, limits.following_error / DOUBT, "'s link would swing by {:.2g} rad"),
            (self.speed, FAST * limits.velocity, " would overshoot to {:.2g} rad/s"),
            (self.torque, STRONG * limits.torque, " would need {:.3g} N·m with its friction"),
        )


def predicted(
    robot: Robot,
    limits: ArmLimits,
    gains: PidGains,
    figures: JointFigures,
    motion: MotionSamples,
    ahead: Array,
) -> Predicted:
    """Of a motion (N, n) from rest with the torque ``ahead`` (N, n) N·m that is given with it: the
    worst of all that the bodies may be, but the torque that is as likely too much as too little: a
    joint that lacks some falls behind, and its following error ends that; nothing is hurt by it."""
    which = range(len(figures.bodies)) or [0]
    found = [_of_one(robot, limits, gains, figures, motion, ahead, k) for k in which]
    worst = Predicted(*(np.max([getattr(one, k) for one in found], axis=0) for k in LOOKED_AT))
    return replace(worst, torque=np.median([one.torque for one in found], axis=0))


def _of_one(
    robot: Robot,
    limits: ArmLimits,
    gains: PidGains,
    figures: JointFigures,
    motion: MotionSamples,
    ahead: Array,
    as_felt: int,
) -> Predicted:
    """With one of the bodies that the arm may have."""
    t, q, dq, ddq = motion
    bodies = figures.bodies[as_felt] if len(figures.bodies) else robot.parameters
    held = inverse_dynamics(robot, bodies, q[:1], np.zeros_like(q[:1]), np.zeros_like(q[:1]))
    needed = torque_ahead(robot, figures, motion, as_felt, LOSS)
    if not len(figures.bodies):
        own = np.diagonal(mass_matrices(robot, q), axis1=1, axis2=2) * ddq
        needed = needed + inverse_dynamics(robot, bodies, q, dq, ddq) - own - held
    inertia, rate = inertias(robot, figures).usual, 1.0 / float(t[1] - t[0])
    link, pull = links_along(robot, figures, bodies, q)
    error, slip, swing = np.zeros_like(q), np.zeros_like(q), np.zeros_like(q)
    links = links_of(robot, figures, bodies, motion, LOSS).q
    for j in range(robot.n):
        above, below = np.array([1.0]), np.array([inertia[j], figures.viscous[j], -pull[j]])
        if np.isfinite(figures.stiffness[j]):
            late, spring = behind_spring(link[j], float(figures.stiffness[j]), pull[j], LOSS)
            moved = np.polymul([figures.motor[j], figures.viscous[j], 0.0], late)
            slowly = spring[-1] / late[-1]
            swing[:, j] = links[:, j] - q[0, j] - slowly * (q[:, j] - q[0, j])
            above, below = late, np.polyadd(moved, np.polymul([link[j], 0.0, -pull[j]], spring))
        servo = [gains.kd[j], gains.kp[j], gains.ki[j]]
        closed = np.polyadd(np.polymul(below, [1.0, 0.0]), np.polymul(above, servo))
        push = needed[:, j] - ahead[:, j]
        for out, order in ((error, [1.0, 0.0]), (slip, [1.0, 0.0, 0.0])):
            out[:, j] = filtered(np.polymul(above, order), closed, rate, push - push[0])
    return Predicted(
        np.abs(error).max(axis=0),
        np.abs(swing).max(axis=0),
        np.abs(dq - slip).max(axis=0),
        np.abs(needed + held).max(axis=0),
        _beyond(limits, q, dq, error, slip),
    )


def _beyond(limits: ArmLimits, q: Array, dq: Array, error: Array, slip: Array) -> Array:
    """(n,) rad: see ``Predicted.beyond``; to either side of the path, and with the way to brake."""
    stops = []
    for side in (DOUBT, 0.0, -DOUBT):
        at, speed = q - side * error, dq - side * slip
        stops.append(at + speed * np.abs(speed) / (2.0 * limits.acceleration))
    beyond = np.maximum(np.max(stops, axis=0) - limits.upper, limits.lower - np.min(stops, axis=0))
    return np.nan_to_num(beyond, neginf=-np.inf).max(axis=0)
