"""Where one joint can be moved freely, and what gravity does to it there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.trajectory.capsules import Capsules, capsules_of
from pa10d.trajectory.limits import POSITION_MARGIN, MotionLimits, limits_of

Array = NDArray[np.float64]

CLEAR = 0.03  # m to keep between bodies
GRAVITY_SHARE = 0.8  # of a torque limit that gravity may use: the rest is for motion and friction
STEP, LOOK = 0.02, 0.05  # rad between looks along a range, along a way
ROUNDING = 1e-6  # rad
NO_GRAVITY = 0.02  # of the joint's own worst gravity torque, below which gravity does not act


@dataclass(frozen=True)
class Surroundings:
    """An arm and what it must not meet. limits: what plans may use; gravity_share: of their torque,
    that gravity may use."""

    robot: Robot
    limits: MotionLimits
    gravity_share: float = GRAVITY_SHARE

    @classmethod
    def of(cls, robot: Robot) -> Surroundings:
        """With the usual margins."""
        return cls(robot, limits_of(robot).planned())

    @cached_property
    def room(self) -> MotionLimits:
        """Where poses are chosen that nobody has asked for."""
        return self.limits.within_a_turn(~self.robot.prismatic)

    @cached_property
    def capsules(self) -> Capsules:
        """The bodies."""
        return capsules_of(self.robot)

    def gravity(self, q: Array) -> Array:
        """(N, n) N·m that holds the poses q (N, n), by the robot's own parameters."""
        zero = np.zeros_like(q)
        return inverse_dynamics(self.robot, self.robot.parameters, q, zero, zero)

    def allowed(self, q: Array) -> NDArray[np.bool_]:
        """(N,) True where bodies keep apart, gravity leaves torque over, limits hold."""
        gaps = self.capsules.clearance(q)
        clear = np.all(gaps >= CLEAR, axis=1)
        light = np.all(np.abs(self.gravity(q)) <= self.gravity_share * self.limits.torque, axis=1)
        inside = np.all((q >= self.limits.lower) & (q <= self.limits.upper), axis=1)
        return np.asarray(clear & light & inside)

    def within(self, pose: Array, what: str) -> Array:
        """The pose (n,) rad that somebody gives, if the joints go there; margins aside."""
        low, high = self.limits.lower - POSITION_MARGIN, self.limits.upper + POSITION_MARGIN
        outside = np.flatnonzero((pose < low - ROUNDING) | (pose > high + ROUNDING))
        if outside.size:
            j = int(outside[0])
            raise UserError(
                f"{what}: joint {j + 1}: found {pose[j]:.4g} rad, expected {low[j]:.4g} … "
                f"{high[j]:.4g}, its limits"
            )
        return pose

    def free_range(self, pose: Array, joint: int) -> tuple[float, float]:
        """The range of one joint (0-based) around a pose in which every angle is allowed."""
        lower, upper = self.limits.lower[joint], self.limits.upper[joint]
        count = int(np.ceil((upper - lower) / STEP)) + 1
        angles = np.union1d(np.linspace(lower, upper, count), [pose[joint]])
        poses = np.tile(pose, (len(angles), 1))
        poses[:, joint] = angles
        fine = self.allowed(poses)
        here = int(np.searchsorted(angles, pose[joint]))
        if not fine[here]:
            raise UserError(
                f"the pose {np.round(pose, 3).tolist()} is not free: {self._taken(pose)}; expected "
                "another pose"
            )
        blocked = np.flatnonzero(~fine)
        below, above = blocked[blocked < here], blocked[blocked > here]
        first = int(below[-1]) + 1 if below.size else 0
        last = int(above[0]) - 1 if above.size else len(angles) - 1
        return float(angles[first]), float(angles[last])

    def _taken(self, pose: Array) -> str:
        """What is wrong with a pose (n,) that is not allowed."""
        outside = (pose < self.limits.lower) | (pose > self.limits.upper)
        if outside.any():
            return f"joint {int(np.argmax(outside)) + 1} is beyond its limit"
        gaps = self.capsules.clearance(pose[None])[0]
        if (gaps < CLEAR).any():
            near = self.capsules.name(int(np.argmin(gaps)))
            return f"{near} are nearer than {CLEAR:g} m"
        shares = np.abs(self.gravity(pose[None])[0]) / self.limits.torque
        j = int(np.argmax(shares))
        return (
            f"gravity takes {shares[j]:.0%} of what joint {j + 1} may give by the URDF's masses "
            "(correct them where the arm is lighter), planned with are "
            f"{self.gravity_share:.0%} at most"
        )

    def free_share(self, here: Array, there: Array) -> float:
        """Of the straight way, what can be gone before bodies come near each other."""
        steps = max(2, int(np.abs(there - here).max() / LOOK) + 1)
        share = np.linspace(0, 1, steps)
        gaps = self.capsules.clearance(here + share[:, None] * (there - here))
        bad = np.flatnonzero((gaps < CLEAR).any(axis=1))
        return float(share[max(bad[0] - 1, 0)]) if bad.size else 1.0

    def reachable(self, pose: Array) -> bool:
        """Whether the straight way from the rest pose is free: then any two such poses have one."""
        return self.free_share(self.limits.rest_pose(), pose) == 1.0

    def random_pose(self, rng: np.random.Generator, share: float = 0.7, tries: int = 400) -> Array:
        """An allowed pose within a share of every range, in reach of the rest pose."""
        mid, half = self.room.middle, self.room.half
        for _ in range(tries):
            pose = mid + share * half * rng.uniform(-1, 1, self.robot.n)
            if self.allowed(pose[None])[0] and self.reachable(pose):
                return pose
        why = "bodies come near each other on the straight way from the rest pose"
        if not self.allowed(pose[None])[0]:
            why = self._taken(pose)
        raise UserError(
            f"none of {tries} random poses is free of collisions and light enough for the torque "
            f"limits; of the last: {why}; expected wider limits, stronger joints, other masses in "
            "the URDF or less around it (environment)"
        )

    def load(self, pose: Array, joint: int) -> float:
        """N·m by which gravity loads a joint at a pose."""
        return float(self.gravity(pose[None])[0, joint])


@dataclass(frozen=True)
class GravityFree:
    """The best pose for a joint. share: what gravity is left, of the worst in any pose found."""

    pose: Array
    share: float

    @property
    def free(self) -> bool:
        """Whether gravity can be forgotten there."""
        return self.share < NO_GRAVITY


def gravity_free_pose(
    around: Surroundings, joint: int, travel: float = 0.5, seed: int = 1, tries: int = 300
) -> GravityFree:
    """A pose in which moving one joint (0-based) by ±travel rad lifts nothing: its axis is
    vertical there, or it carries its mass on the axis. Random poses, the best ones refined joint
    by joint on a grid of multiples of 90° and around."""
    rng = np.random.default_rng(seed)
    limits = around.limits
    steps = np.linspace(-travel, travel, 5)

    def left(poses: Array) -> Array:
        whole = np.repeat(poses, len(steps), axis=0)
        whole[:, joint] += np.tile(steps, len(poses))
        fine = around.allowed(whole).reshape(len(poses), -1).all(axis=1)
        torque = np.abs(around.gravity(whole)[:, joint]).reshape(len(poses), -1).max(axis=1)
        return np.where(fine, torque, np.inf)

    home = limits.rest_pose()
    drawn = rng.uniform(around.room.lower, around.room.upper, (tries, around.robot.n))
    quarters = np.clip(np.round(drawn / (np.pi / 2)) * (np.pi / 2), limits.lower, limits.upper)
    poses = np.vstack([home, quarters, drawn])
    poses[:, joint] = home[joint]
    torque = left(poses)
    usable = np.isfinite(torque)
    if not usable.any():
        raise UserError(
            f"joint {joint + 1} can nowhere be moved by ±{travel:.2g} rad: every pose that was "
            "tried meets a limit, a body or what stands around; expected a smaller travel"
        )
    worst = float(torque[usable].max())
    # of poses that are equally good the one nearest home: less to move
    near = np.linalg.norm(poses - home, axis=1)
    order = np.lexsort([near, np.round(torque / max(worst, 1e-9), 3)])
    first = next((k for k in order if around.reachable(poses[k])), order[0])
    best, value = poses[first].copy(), float(torque[first])
    for width in (0.4, 0.1, 0.02, 0.004):
        if value < NO_GRAVITY * worst:
            break
        for other in range(around.robot.n):
            if other == joint:
                continue
            moved = np.tile(best, (41, 1))
            moved[:, other] += np.linspace(-width, width, 41)
            torque = left(moved)
            k = int(np.argmin(torque))
            if torque[k] < value:
                best, value = moved[k].copy(), float(torque[k])
    for other in range(around.robot.n):  # joints that do not matter stay at home
        if other != joint:
            plain = best.copy()
            plain[other] = home[other]
            remains = float(left(plain[None])[0])
            if remains <= max(value, 0.1 * NO_GRAVITY * worst):
                best, value = plain, remains
    return GravityFree(best, value / worst if worst > 0 else 0.0)
