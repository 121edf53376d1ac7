"""An arm as its profile tunes it: every value in force, where it comes from, and what bounds it."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from backends.scaling import scaling_of
from pa10d.control.gains import PidGains, loop_sensitivity, pid_gains
from pa10d.control.joint_figures import presumed_figures
from pa10d.control.known_joints import MeasuredJoints
from pa10d.control.limits import usual_following_error, usual_torque_rate
from pa10d.dynamics import Robot
from pa10d.dynamics.robot import robot_from_urdf
from pa10d.profile import Profile
from pa10d.services.joints import kept_joints, learnt

Array = NDArray[np.float64]
GAINS = ("kp", "ki", "kd")
Source = Literal["profile", "measured", "rule", "URDF", "nobody"]


@dataclass(frozen=True)
class Tuned:
    """A profile with its arm; measured: what is known of its joints, see ``services.joints``."""

    profile: Profile
    robot: Robot
    measured: MeasuredJoints | None

    @staticmethod
    def of(data: str | os.PathLike[str] | None, profile: Profile, robot: Robot) -> Tuned:
        """With what was measured of it."""
        return Tuned(profile, robot, kept_joints(data, profile))

    def with_profile(self, profile: Profile, robot: Robot) -> Tuned:
        """The same arm tuned otherwise: friction and inertia are what they were, and the gains that
        follow from them follow anew."""
        if self.measured is None:
            return Tuned(profile, robot, None)
        again = learnt(profile, robot, self.measured.known.figures)
        return Tuned(profile, robot, replace(self.measured, known=again))

    @cached_property
    def bare(self) -> Robot:
        """The URDF's own arm."""
        return robot_from_urdf(self.profile.urdf, self.profile.joints)

    @cached_property
    def gains(self) -> PidGains:
        """In force with a plain servo."""
        found = pid_gains(self.robot, self.profile.control)
        if self.measured is None:
            return found
        given, fitted = self.profile.control.gains, self.measured.known.gains
        kp, ki, kd = (getattr(found if getattr(given, k) else fitted, k) for k in GAINS)
        return PidGains(kp, ki, kd, fitted.push, pull=fitted.pull)

    @cached_property
    def sensitivity(self) -> Array:
        """(n,) peak of the loop's sensitivity by the inertias that are known, inf: it swings up."""
        figures = (
            presumed_figures(self.robot) if self.measured is None else self.measured.known.figures
        )
        return loop_sensitivity(self.robot, self.profile.control, figures, self.gains)

    def in_force(self, name: str) -> Any:
        """The value of a key: a number, a word, (n,) or (n, 2), inf where nothing is known."""
        robot, profile = self.robot, self.profile
        if name.startswith("control.gains."):
            return getattr(self.gains, name.rpartition(".")[2])
        match name:
            case "control.bandwidth_hz":
                return profile.control.servo_bandwidth
            case "limits.position":
                return np.stack([robot.lower, robot.upper], axis=1)
            case "limits.velocity":
                return robot.velocity
            case "limits.acceleration":
                return robot.acceleration
            case "limits.torque":
                return robot.effort
            case "safety.following_error":
                given = profile.safety.following_error
                return usual_following_error(robot) if given is None else np.array(given)
            case "safety.torque_rate":
                given = profile.safety.torque_rate
                return usual_torque_rate(robot) if given is None else np.array(given)
            case "environment.floor":
                return profile.environment.floor
            case "environment.boxes":
                boxes = profile.environment.boxes
                return [box.model_dump(mode="json", exclude_defaults=True) for box in boxes]
            case "drives.torque_gain":
                drives = profile.drives
                return [drive.torque_gain for drive in drives] if drives else [1.0] * robot.n
            case "map":
                return profile.map or []
        raise KeyError(name)

    def bounds(self, name: str) -> list[tuple[str, Array]]:
        """By what a value is bounded: words, and (n,) the most, or (n, 2) for positions."""
        match name:
            case "limits.position":
                return [("the URDF's", np.stack([self.bare.lower, self.bare.upper], axis=1))]
            case "limits.velocity":
                return [("the URDF's", self.bare.velocity)]
            case "limits.torque":
                drives = self.profile.drives or []
                rated = np.array([scaling_of(drive).rated for drive in drives])
                own = [("what its drive is rated for,", rated)] if drives else []
                return [("the URDF's", self.bare.effort), *own]
            case "safety.following_error":
                return [("the usual", usual_following_error(self.robot))]
            case "safety.torque_rate":
                return [("the usual", usual_torque_rate(self.robot))]
        return []

    def source(self, name: str, written: Any) -> Source:
        """Who says the value that is in force."""
        if written is not None:
            return "profile"
        if name.startswith("control.gains.") and self.measured is not None:
            return "measured"
        if name == "limits.acceleration":
            return "nobody"
        return "URDF" if name.startswith("limits.") else "rule"
