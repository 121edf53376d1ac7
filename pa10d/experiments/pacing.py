"""As fast as the joints can follow: a motion is slowed until nothing is predicted to end it.

A drive ends a motion at the very limit of a position, so a joint that will not follow well turns
less far: it keeps the error that it may have as its margin.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.control.gains import PidGains
from pa10d.control.joint_figures import JointFigures
from pa10d.control.limits import ArmLimits
from pa10d.dynamics import Robot
from pa10d.experiments.checks import Check, Level
from pa10d.experiments.motion import Whole, measured_torque, whole_motion
from pa10d.experiments.prediction import DOUBT, PACES, Predicted, predicted
from pa10d.trajectory.motions import MotionSamples
from pa10d.trajectory.plan import Plan

Array = NDArray[np.float64]

UNKNOWN = (
    "the joints have not been measured: gains follow the URDF, tracking is not predicted; run "
    "first_motion before"
)
LOOK = 100.0  # Hz
LEAST = 0.5  # of its way that a joint turns at least
STILL = 1e-6  # rad: a joint that does not leave its middle
REMEDY = "use computed torque with a model, a smaller motion, or raise control.rate"


@dataclass(frozen=True)
class Joints:
    """Of a measured arm. ahead: whether the servo is given what was measured."""

    figures: JointFigures
    gains: PidGains
    ahead: bool


@dataclass(frozen=True)
class Adjusted:
    """How a motion differs from what was asked for. pace: how many times slower, 1 for not at all,
    and ``why``; less_far: joint, from 1 -> share of its way that it leaves out."""

    pace: float
    why: str
    less_far: Mapping[int, float]

    @property
    def phrases(self) -> list[str]:
        """What was changed, each with its reason; none where nothing was."""
        said = []
        if self.pace > 1.0:
            said.append(f"{self.why}: run at 1/{self.pace:g} of the speed")
        if self.less_far:
            each = ", ".join(f"joint {j}: {100 * x:.2g} %" for j, x in self.less_far.items())
            said.append(f"turned less far, to keep clear of position limits ({each})")
        return said

    def document(self) -> JsonObject | None:
        """For JSON, with a ``sentence`` for a person; None where nothing was changed."""
        if not self.phrases:
            return None
        return {
            "pace": self.pace,
            "why": self.why,
            "less_far": [{"joint": j, "share": share} for j, share in self.less_far.items()],
            "sentence": f"Not quite as asked for: {'; '.join(self.phrases)}.",
        }


@dataclass(frozen=True)
class Paced:
    """The plan as it can be run, its whole motion, and what is to be said of it."""

    plan: Plan
    whole: Whole
    check: Check
    adjusted: Adjusted | None = None


def paced(
    plan: Plan, start: Array, robot: Robot, limits: ArmLimits, rate: float, joints: Joints
) -> Paced:
    """The plan itself where it can be followed, else at the first pace at which it can; joints that
    would come close to their position limits turn less far."""
    first = ""
    for pace in PACES:
        slower = plan if pace == 1.0 else plan.slowed(pace)
        whole = whole_motion(slower, start, robot, rate, pace)
        found = _predicted(slower, whole, robot, limits, rate, joints)
        problem = found.problem(limits)
        if not problem:
            share, about = _room(whole, limits, found)
            tight = share < 1.0
            if not tight.any():
                done = Adjusted(pace, first, {})
                return Paced(slower, whole, _said(done, found), done)
            j = int(np.argmin(share))
            narrow = slower.narrowed(share, about)
            narrowed = whole_motion(narrow, start, robot, rate, pace)
            if (share >= LEAST).all() and not narrowed.violations:
                done = Adjusted(pace, first, _left_out(share))
                return Paced(narrow, narrowed, _said(done, found), done)
            problem = (
                f"joint {j + 1} comes close to its position limit and may be "
                f"{DOUBT * found.error[j]:.2g} rad from its path"
            )
        first = first or problem
    whole = whole_motion(plan, start, robot, rate)
    text = f"{first}, and at a quarter of the speed {problem}; {REMEDY}"
    return Paced(plan, whole, Check("error", "tracking", text))


def _room(whole: Whole, limits: ArmLimits, found: Predicted) -> tuple[Array, Array]:
    """(n,) each: the share of their ways that leaves joints room for the error that they may have
    and to brake in, and the middles of their ranges, rad; 1 and 0 for all that have room."""
    q = whole.samples.q[whole.first : whole.last]
    bound = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    lower, upper = np.where(bound, limits.lower, -np.inf), np.where(bound, limits.upper, np.inf)
    left = np.minimum(q.min(axis=0) - lower, upper - q.max(axis=0))
    lacking = np.maximum(DOUBT * found.error - left, found.beyond)
    tight = lacking > 0.0
    about = np.zeros_like(left)
    about[tight] = 0.5 * (lower[tight] + upper[tight])
    share = np.ones_like(left)
    reach = np.maximum(0.5 * (upper - lower)[tight] - left[tight], STILL)
    share[tight] = 1.0 - lacking[tight] / reach
    return share, about


def _left_out(share: Array) -> dict[int, float]:
    return {int(j) + 1: float(1.0 - share[j]) for j in np.flatnonzero(share < 1)}


def _said(done: Adjusted, found: Predicted) -> Check:
    j = int(np.argmax(found.error))
    text = f"predicted: at most {found.error[j]:.2g} rad from the path (joint {j + 1})"
    level: Level = "warning" if done.phrases else "ok"
    return Check(level, "tracking", "; ".join([*done.phrases, text]))


def _predicted(
    plan: Plan, whole: Whole, robot: Robot, limits: ArmLimits, rate: float, joints: Joints
) -> Predicted:
    """Looked at with few samples: nothing that a motion asks for is faster."""
    step = max(1, round(rate / LOOK))
    few = MotionSamples(*(x[::step] for x in whole.samples))
    ahead = np.zeros_like(few.q)
    if joints.ahead:
        ahead = measured_torque(plan, whole, robot, joints.figures, rate)[::step]
    return predicted(robot, limits, joints.gains, joints.figures, few, ahead)
