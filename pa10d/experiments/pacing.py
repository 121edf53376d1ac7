"""As fast as the joints can follow: a motion is slowed until nothing is predicted to end it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.control.gains import PidGains
from pa10d.control.joint_figures import JointFigures
from pa10d.control.limits import ArmLimits
from pa10d.dynamics import Robot
from pa10d.experiments.checks import Check
from pa10d.experiments.motion import Whole, measured_torque, whole_motion
from pa10d.experiments.prediction import PACES, Predicted, predicted
from pa10d.trajectory.motions import Samples
from pa10d.trajectory.plan import Plan

Array = NDArray[np.float64]

UNKNOWN = (
    "the joints have not been measured: gains follow the URDF, tracking is not predicted; run "
    "first_motion before"
)
LOOK = 100.0  # Hz
REMEDY = "use computed torque with a model, a smaller motion, or raise control.rate"


@dataclass(frozen=True)
class Joints:
    """Of a measured arm. ahead: whether the servo is given what was measured."""

    figures: JointFigures
    gains: PidGains
    ahead: bool


@dataclass(frozen=True)
class Paced:
    """The plan as it can be run, its whole motion, and what is to be said of it."""

    plan: Plan
    whole: Whole
    check: Check


def paced(
    plan: Plan, start: Array, robot: Robot, limits: ArmLimits, rate: float, joints: Joints
) -> Paced:
    """The plan itself where it can be followed, else at the first pace at which it can."""
    first = ""
    for pace in PACES:
        slower = plan if pace == 1.0 else plan.slowed(pace)
        whole = whole_motion(slower, start, robot, rate, pace)
        found = _predicted(slower, whole, robot, limits, rate, joints)
        problem = found.problem(limits)
        first = first or problem
        if not problem:
            return Paced(slower, whole, _said(pace, first, found))
    whole = whole_motion(plan, start, robot, rate)
    text = f"{first}, and at a quarter of the speed {problem}; {REMEDY}"
    return Paced(plan, whole, Check("error", "tracking", text))


def _said(pace: float, first: str, found: Predicted) -> Check:
    j = int(np.argmax(found.error))
    text = f"predicted: at most {found.error[j]:.2g} rad from the path (joint {j + 1})"
    if pace == 1.0:
        return Check("ok", "tracking", text)
    return Check("warning", "tracking", f"{first}: run at 1/{pace:g} of the speed; {text}")


def _predicted(
    plan: Plan, whole: Whole, robot: Robot, limits: ArmLimits, rate: float, joints: Joints
) -> Predicted:
    """Looked at with few samples: nothing that a motion asks for is faster."""
    step = max(1, round(rate / LOOK))
    few = Samples(*(x[::step] for x in whole.samples))
    ahead = np.zeros_like(few.q)
    if joints.ahead:
        ahead = measured_torque(plan, whole, robot, joints.figures, rate)[::step]
    return predicted(robot, limits, joints.gains, joints.figures, few, ahead)
