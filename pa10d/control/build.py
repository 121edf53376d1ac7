"""From a profile to an arm that can be cycled."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from backends.protocol import Backend
from pa10d.control.arm import LIFTED, Arm
from pa10d.control.gains import burdens, pid_gains
from pa10d.control.joint_figures import ROUGH, inertias, inertias_alone, presumed_figures
from pa10d.control.journal import Journal
from pa10d.control.limits import arm_limits
from pa10d.control.pid import Pid
from pa10d.control.ring import Ring
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.profile import Profile

Array = NDArray[np.float64]


def servo_factory(profile: Profile, robot: Robot, period: float) -> Callable[[], Pid]:
    """Makes joint servos with the profile's gains."""
    limits, gains = arm_limits(profile, robot), pid_gains(robot, profile.control)
    return lambda: Pid(gains, limits.torque, period)


def weight_of(robot: Robot, bodies: Array) -> Callable[[Array], Array]:
    """N·m (n,) that hold bodies (n, 10) in a pose (n,) rad."""
    still = np.zeros((1, robot.n))
    return lambda q: inverse_dynamics(robot, bodies, q[None], still, still)[0]


def build_arm(profile: Profile, robot: Robot, backend: Backend, ring: Ring) -> Arm:
    """The arm of a profile on a backend; offline until ``connect``."""
    presumed, gravity = presumed_figures(robot), weight_of(robot, robot.parameters)
    gravity(np.zeros(robot.n))  # compiled before it is needed
    most = ROUGH * burdens(robot, presumed)  # and by as much a radian it changes
    return Arm(
        backend,
        arm_limits(profile, robot),
        servo_factory(profile, robot, backend.period),
        gravity,
        Journal(ring),
        np.maximum(most, LIFTED * robot.effort),
        (inertias(robot, presumed).usual, inertias_alone(robot, presumed)),
        most,
    )
