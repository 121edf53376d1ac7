"""A plan as the loop follows it: the way from where the arm stands, the plan, a moment of rest."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.control.gains import PUSH
from pa10d.control.joint_figures import ROUGH, JointFigures
from pa10d.control.live_model import LiveModel, remainder
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.experiments.shaking import small_torques, torque_ahead
from pa10d.model import TorqueModel
from pa10d.trajectory.check import Violation, check
from pa10d.trajectory.limits import limits_of
from pa10d.trajectory.motions import MotionSamples
from pa10d.trajectory.plan import GENTLE, Plan, move
from pa10d.trajectory.poses import Surroundings
from pa10d.trajectory.ways import free_way

Array = NDArray[np.float64]
Rows = tuple[Array, Array, Array]

SETTLE = 0.5  # s at rest before and after the plan
STICKS = 0.25  # of the torque limit: more dry friction than that holds no joint that is to move
BEHIND = 0.5  # of the bound of the following error, until such a joint has come loose
ASTRAY = 0.1  # … that a joint may be from where a motion left it


@dataclass(frozen=True)
class Whole:
    """samples at the loop's rate; rows first … last-1 are the plan itself, which is recorded."""

    samples: MotionSamples
    first: int
    last: int
    violations: tuple[Violation, ...]


def whole_motion(
    plan: Plan,
    start: Array,
    robot: Robot,
    rate: float,
    pace: float = 1.0,
    softly: Array | None = None,
) -> Whole:
    """From ``start`` (n,) rad at rest to the end of the plan, and what is wrong with it.

    The way is one on which the arm meets nothing; pace: how many times slower than usual; softly:
    (n,) rad/s² by which each joint gathers speed on it at most.
    """
    around, pause = Surroundings.of(robot), round(SETTLE * rate)
    limits = around.limits
    if softly is not None:
        limits = replace(limits, acceleration=np.minimum(limits.acceleration, softly / GENTLE))
    lead = _standing(start, pause)
    here = start
    for point in free_way(around, start, plan.start):
        motion = move(here, point, limits, GENTLE / pace**2)
        t = np.arange(1.0, np.ceil(motion.duration * rate) + 1) / rate
        lead = _after(lead, motion.at(np.minimum(t, motion.duration)))
        lead = _after(lead, _standing(point, pause))
        here = point
    body = plan.sample(rate)[1:]
    rows = _after(_after(lead, body), _standing(plan.segments[-1].motion.end, pause))
    samples = MotionSamples(np.arange(float(len(rows[0]))) / rate, *rows)
    violations = check(samples, robot, limits_of(robot), measured=start)
    return Whole(samples, len(lead[0]), len(lead[0]) + len(body[0]), tuple(violations))


def as_lighter(whole: Whole) -> Whole:
    """A first motion: how much torque it takes is not judged by the masses of a URDF, which may be
    ``ROUGH`` times too heavy, but measured. A motor chosen for its arm gives what that takes; where
    it does not, its joint falls behind, which ends the motion."""
    kept = [v for v in whole.violations if v.kind != "torque" or abs(v.value) > ROUGH * v.limit]
    return whole if len(kept) == len(whole.violations) else replace(whole, violations=tuple(kept))


def softly(figures: JointFigures, bound: Array, away: Array) -> Array | None:
    """(n,) rad/s² for the way of an arm that is only being measured; None for the usual way.

    A joint that sticks is pushed by a torque that grows, and its servo may be too weak to help: its
    path has to wait until that torque is as large as friction may be. Where friction is known that
    is so after a fault alone, which leaves more than the joint that strokes away from its place.
    bound: (n,) rad; away: (n,) rad, from where the arm stands to where the plan begins.
    """
    known = not bool((figures.doubt >= ROUGH).all())
    if known and np.count_nonzero(np.abs(away) > ASTRAY * bound) <= 1:
        return None
    return np.asarray(2.0 * BEHIND * bound / (STICKS / PUSH) ** 2)


def rows_of(whole: Whole, model: TorqueModel | None, live: LiveModel | None) -> Array:
    """(N, 4n) rows of q, dq, ddq and the torque that the loop's own model does not know."""
    t, q, dq, ddq = whole.samples
    extra = np.zeros_like(q)
    if model is not None and live is not None:
        extra = remainder(model, live, q, dq, ddq, float(t[1] - t[0]))
    return np.hstack([q, dq, ddq, extra])


def measured_torque(
    plan: Plan, whole: Whole, robot: Robot, figures: JointFigures, rate: float
) -> Array:
    """(N, n) N·m that measured friction and inertia ask for along the motion, and the small torques
    of a first motion on top; no more than a joint can give beside what holds it where it begins:
    one that carries much there, and as much the other way later, asks for more than its limit."""
    ahead = torque_ahead(robot, figures, whole.samples)
    t = np.arange(1.0, whole.last - whole.first + 1.0) / rate
    ahead[whole.first : whole.last] += small_torques(plan, robot, figures, t, rate)
    held = np.zeros(robot.n)
    if len(figures.bodies):
        still = np.zeros((1, robot.n))
        held = inverse_dynamics(robot, figures.bodies[0], whole.samples.q[:1], still, still)[0]
    held = np.clip(held, -robot.effort, robot.effort)  # that holds it, whatever a URDF says
    return np.clip(ahead, -robot.effort - held, robot.effort - held)


def weight_between(robot: Robot, figures: JointFigures, q: Array) -> Array | None:
    """(2, n) N·m, least and most, that joints may weigh in a pose (n,) rad, by all bodies that they
    may have; None of an arm whose bodies nobody has felt."""
    if not len(figures.bodies):
        return None
    still = np.zeros((1, robot.n))
    held = [inverse_dynamics(robot, b, q[None], still, still)[0] for b in figures.bodies]
    return np.array([np.min(held, axis=0), np.max(held, axis=0)])


def _standing(q: Array, count: int) -> Rows:
    rows = np.repeat(np.asarray(q)[None], count, axis=0)
    return rows, np.zeros_like(rows), np.zeros_like(rows)


def _after(first: Rows, then: Rows) -> Rows:
    q, dq, ddq = (np.concatenate(pair) for pair in zip(first, then, strict=True))
    return q, dq, ddq
