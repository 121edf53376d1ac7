"""As fast as the joints can follow: a motion is slowed until nothing is predicted to end it.

A drive ends a motion at the very limit of a position, so a joint that will not follow well turns
less far: it keeps the error that it may have as its margin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.control.envelope import OVERSHOOT
from pa10d.control.gains import PidGains
from pa10d.control.joint_figures import JointFigures
from pa10d.control.limits import ArmLimits
from pa10d.dynamics import Robot
from pa10d.experiments.checks import Check, Level
from pa10d.experiments.motion import Whole, measured_torque, whole_motion
from pa10d.experiments.prediction import DOUBT, PACES, Predicted, predicted
from pa10d.experiments.slower import AS_ASKED, SLOWEST, Slower
from pa10d.trajectory.motions import MotionSamples
from pa10d.trajectory.plan import Plan

Array = NDArray[np.float64]

UNKNOWN = (
    "the joints have not been measured: gains follow the URDF, tracking is not predicted; run "
    "first_motion before"
)
LOOK = 100.0  # Hz
LEAST = 0.5  # of its way that a joint turns at least
SMALLER = 0.9  # of what a joint may be off, that is aimed at where it turns less far for that
SMALLER_YET = (0.7, 0.5, 0.35, 0.25, 0.15, 0.1)  # shares of a motion that first weighs the arm
UNHURRIED = (1.0, 2.0, SLOWEST)  # paces at which those are looked at
WORTH_A_WORD = 1e-3  # of its way, that a joint leaves out
STILL = 1e-6  # rad: a joint that does not leave its middle
IN_DOUBT = (
    "{}: what the arm weighs is too much in doubt for the whole of it; {:.0%} of it is run before, "
    "which tells"
)
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
    and ``why``; joint, from 1 -> share of its way that it leaves out: less_far, for its position
    limits, smaller, because it could not be followed at any pace."""

    pace: float
    why: str
    less_far: Mapping[int, float]
    smaller: Mapping[int, float] = field(default_factory=dict)

    @property
    def phrases(self) -> list[str]:
        """What was changed, each with its reason; none where nothing was."""
        said = []
        if self.pace > 1.0:
            said.append(f"{self.why}: run at 1/{self.pace:g} of the speed")
        for left_out, why in (
            (self.less_far, "to keep clear of position limits"),
            (self.smaller, "to keep to their paths"),
        ):
            seen = {j: x for j, x in left_out.items() if x >= WORTH_A_WORD}
            each = ", ".join(f"joint {j}: {100 * x:.2g} %" for j, x in seen.items())
            said += [f"turned less far, {why} ({each})"] if each else []
        return said

    def document(self) -> JsonObject | None:
        """For JSON, with a ``sentence`` for a person; None where nothing was changed."""
        if not self.phrases:
            return None
        return {
            "pace": self.pace,
            "why": self.why,
            "less_far": _listed(self.less_far),
            "smaller": _listed(self.smaller),
            "sentence": f"Not quite as asked for: {'; '.join(self.phrases)}.",
        }


@dataclass(frozen=True)
class Paced:
    """The plan as it can be run, its whole motion, and what is to be said of it. weighs: of a plan
    that nothing bars but what the arm may weigh, the share of it that can be run, and tell."""

    plan: Plan
    whole: Whole
    check: Check
    adjusted: Adjusted | None = None
    weighs: float | None = None


def paced(
    plan: Plan,
    start: Array,
    robot: Robot,
    limits: ArmLimits,
    rate: float,
    joints: Joints,
    slower: Slower = AS_ASKED,
    remedy: Callable[[], str] = lambda: REMEDY,
) -> Paced:
    """The plan itself where it can be followed, else at the first pace at which it can; joints that
    would come close to their position limits turn less far, and so do those that could be followed
    at no pace: what gravity may be off by does not get less by slowness alone. remedy: what to do
    about a motion that is refused."""

    def as_felt(whole: Whole) -> Whole:
        return _without_torque(whole) if len(joints.figures.bodies) else whole

    def looked_at(tried: Plan, pace: float) -> tuple[Whole, Predicted]:
        whole = as_felt(whole_motion(tried, start, robot, rate, pace))
        return whole, _predicted(tried, whole, robot, limits, rate, joints)

    def followed(tried: Plan, whole: Whole, found: Predicted, done: Adjusted) -> Paced | str:
        if problem := found.problem(limits):
            return problem
        share, about = _room(whole, limits, found, slower)
        tight = share < 1.0
        if not tight.any():
            return Paced(tried, whole, _said(done, found), done)
        narrow = tried.narrowed(share, about)
        narrowed = as_felt(whole_motion(narrow, start, robot, rate, done.pace))
        if (share >= LEAST).all() and not narrowed.violations:
            done = replace(done, less_far=_left_out(share))
            return Paced(narrow, narrowed, _said(done, found), done)
        j = int(np.argmin(share))
        return limits.in_units(
            j,
            f"joint {j + 1} comes close to its position limit and may be "
            f"{DOUBT * found.error[j]:.2g} rad from its path",
        )

    first = slower.why
    if slower.small < 1.0:
        plan = plan.narrowed(np.full(robot.n, slower.small), start)
    for pace in (pace for pace in PACES if pace >= slower.pace):
        slowed = plan if pace == 1.0 else plan.slowed(pace)
        whole, found = looked_at(slowed, pace)
        answer = followed(slowed, whole, found, Adjusted(pace, first, {}))
        if isinstance(answer, Paced):
            return answer
        first = first or answer
    share = np.ones(robot.n)
    while (share := share * SMALLER / np.maximum(found.over(limits), SMALLER)).min() >= LEAST:
        small = slowed.narrowed(share, start)  # where what holds the arm is known
        whole, found = looked_at(small, pace)
        done = Adjusted(pace, first, {}, _left_out(share))
        tried = followed(small, whole, found, done)
        if isinstance(tried, Paced) and not tried.whole.violations:
            return tried
        if not (found.over(limits) > 1.0).any():
            break
    whole = whole_motion(plan, start, robot, rate)
    if slower.small == 1.0:
        weighs = _weighing_share(plan, start, robot, limits, rate, joints)
        if weighs is not None:
            said = Check("warning", "tracking", IN_DOUBT.format(first, weighs))
            return Paced(plan, as_felt(whole_motion(plan, start, robot, rate)), said, weighs=weighs)
    text = f"{first}, and at a quarter of the speed {answer}; {remedy()}"
    return Paced(plan, whole, Check("error", "tracking", text))


def _weighing_share(
    plan: Plan, start: Array, robot: Robot, limits: ArmLimits, rate: float, joints: Joints
) -> float | None:
    """See ``Paced.weighs``; None where the likeliest bodies are not followed, or no share is."""

    def followed(tried: Plan, pace: float, known: Joints) -> bool:
        whole = _without_torque(whole_motion(tried, start, robot, rate, pace))
        found = _predicted(tried, whole, robot, limits, rate, known)
        room, _ = _room(whole, limits, found, AS_ASKED)
        return not found.problem(limits) and not whole.violations and bool((room >= LEAST).all())

    bodies = joints.figures.bodies
    likeliest = replace(joints, figures=joints.figures.but(bodies=bodies[:1]))
    if len(bodies) < 2 or not followed(plan.slowed(SLOWEST), SLOWEST, likeliest):
        return None
    for share in SMALLER_YET:
        small = plan.narrowed(np.full(robot.n, share), start)
        if any(followed(small.slowed(pace), pace, joints) for pace in UNHURRIED):
            return share
    return None


def _without_torque(whole: Whole) -> Whole:
    """Without what a rough URDF says of torque, where the prediction has it by the bodies as they
    were felt and all that they may be, with friction."""
    return replace(whole, violations=tuple(v for v in whole.violations if v.kind != "torque"))


def _room(whole: Whole, limits: ArmLimits, found: Predicted, slower: Slower) -> tuple[Array, Array]:
    """(n,) each: the share of their ways that leaves joints room for the error that they may have
    and to brake in, and the middles of their ranges, rad; 1 and 0 for all that have room. A joint
    that has come to its limit all the same gets more: of what is beyond it, too."""
    q = whole.samples.q[whole.first : whole.last]
    bound = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    lower, upper = np.where(bound, limits.lower, -np.inf), np.where(bound, limits.upper, np.inf)
    left = np.minimum(q.min(axis=0) - lower, upper - q.max(axis=0))
    needed = DOUBT * found.error
    if len(slower.room):
        times = np.array(slower.room)
        needed = times * (needed + np.where(times > 1.0, OVERSHOOT, 0.0))
    lacking = np.maximum(needed - left, found.beyond)
    tight = lacking > 0.0
    about = np.zeros_like(left)
    about[tight] = 0.5 * (lower[tight] + upper[tight])
    share = np.ones_like(left)
    reach = np.maximum(0.5 * (upper - lower)[tight] - left[tight], STILL)
    share[tight] = 1.0 - lacking[tight] / reach
    return share, about


def _listed(left_out: Mapping[int, float]) -> list[dict[str, float]]:
    return [{"joint": j, "share": share} for j, share in left_out.items()]


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
