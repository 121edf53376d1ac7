"""The search space of exciting trajectories: Fourier coefficients, their cost and their limits."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.dynamics.observation import ObservationColumns, model_columns, observation_columns
from pa10d.trajectory.capsules import Capsules, capsules_of
from pa10d.trajectory.excitation.criterion import Bases, Criterion
from pa10d.trajectory.fourier import fourier_basis
from pa10d.trajectory.limits import MotionLimits, limits_of
from pa10d.trajectory.subarm import sub_arm

Array = NDArray[np.float64]

FINE = 4  # grid of the limits: points per sample
RESERVE = 0.01  # of torque that the search keeps beyond the plan's own margin
CLEAR, CLEAR_RESERVE = 0.03, 0.005  # m to keep between bodies, and what the search adds


@dataclass(frozen=True)
class ExcitationProblem:
    """Which joints of which arm to excite, how long, within what.

    robot     the whole arm; joints (m,) 0-based, the others are held at pose (n,)
    limits    of the whole arm, as a plan may use them
    samples   of one period, at which the observation matrix is formed
    """

    robot: Robot
    joints: tuple[int, ...]
    pose: tuple[float, ...]
    limits: MotionLimits
    fundamental: float = 0.1
    harmonics: int = 5
    samples: int = 100
    criterion: Criterion = field(default_factory=Criterion)

    @classmethod
    def of(
        cls, robot: Robot, joints: tuple[int, ...] | None = None, **options: object
    ) -> ExcitationProblem:
        """A problem with the usual margins, other joints at rest."""
        limits = limits_of(robot)
        room = limits.planned().within_a_turn(~robot.prismatic)
        given: dict = {"pose": tuple(limits.rest_pose()), "limits": room, **options}
        return cls(robot, tuple(range(robot.n)) if joints is None else joints, **given)

    @cached_property
    def arm(self) -> Robot:
        """The moving joints alone."""
        return sub_arm(self.robot, np.array(self.joints), np.array(self.pose))

    @cached_property
    def room(self) -> MotionLimits:
        """Limits of the moving joints."""
        return self.limits.of(np.array(self.joints))

    @cached_property
    def columns(self) -> ObservationColumns:
        """Columns of the observation matrix."""
        return observation_columns(self.arm)

    @cached_property
    def bases(self) -> Bases:
        """These columns, and those in which models are estimated."""
        return Bases.of(self.columns, model_columns(self.arm))

    @cached_property
    def capsules(self) -> Capsules:
        """Bodies of the whole arm."""
        return capsules_of(self.robot)

    @cached_property
    def fine(self) -> tuple[Array, Array, Array]:
        """Basis matrices on the grid of the limits; every FINE-th row is a sample."""
        count = self.samples * FINE
        t = np.arange(count) / (count * self.fundamental)
        return fourier_basis(self.fundamental, self.harmonics, t)

    @cached_property
    def coarse(self) -> tuple[Array, Array, Array]:
        """Basis matrices at the samples."""
        b0, b1, b2 = (np.ascontiguousarray(b[::FINE]) for b in self.fine)
        return b0, b1, b2

    @property
    def shape(self) -> tuple[int, int]:
        """Of the coefficients: rows [q0, a, b], one column per moving joint."""
        return 1 + 2 * self.harmonics, len(self.joints)

    @cached_property
    def scale(self) -> Array:
        """Natural size of each coefficient: what the velocity limit allows a harmonic."""
        order = 2 * np.pi * self.fundamental * np.arange(1, self.harmonics + 1)
        waves = np.outer(np.tile(1 / order, 2), self.room.velocity)
        return np.vstack([self.room.half, np.minimum(waves, self.room.half)])

    def motion(self, x: Array) -> tuple[Array, Array, Array]:
        """q, q̇, q̈ of the moving joints at the samples, (samples, m)."""
        b0, b1, b2 = self.coarse
        return b0 @ x, b1 @ x, b2 @ x

    def whole(self, q: Array) -> Array:
        """Positions of all joints (N, n) for those of the moving ones (N, m)."""
        out = np.tile(np.array(self.pose), (len(q), 1))
        out[:, list(self.joints)] = q
        return out

    def arm_torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Rigid torque (N, m) of the moving joints by the URDF's parameters, without friction."""
        return inverse_dynamics(self.arm, self.arm.parameters, q, dq, ddq)

    def observation(self, x: Array) -> Array:
        """(samples·m, k) observation matrix."""
        return self.columns.matrix(*self.motion(x)).reshape(-1, len(self.columns))

    def condition_number(self, x: Array) -> float:
        """2-norm, SI units, unweighted, all samples."""
        return float(np.linalg.cond(self.observation(x)))

    def cost(self, x: Array, sharpness: float, penalty: float) -> tuple[float, Array]:
        """log of the criterion plus penalty·violations², and the gradient, shape as x."""
        q, dq, ddq = self.motion(x)
        matrix = self.columns.matrix(q, dq, ddq)
        value, weights, grad_dq = self.criterion.cost(matrix, dq, self.bases, sharpness)
        over, push = self._torque(q, dq, ddq)
        value += penalty * over
        torque = None if push is None else penalty * push
        from_q, from_dq, from_ddq = self.columns.gradient(q, dq, ddq, weights, torque)
        if self.capsules.pairs.size or self.capsules.grounded.size:
            inside, slope = self.capsules.hinge(self.whole(q), CLEAR + CLEAR_RESERVE)
            value += penalty * inside / CLEAR**2 / self.samples
            from_q += penalty * slope[:, list(self.joints)] / CLEAR**2 / self.samples
        b0, b1, b2 = self.coarse
        grad = b0.T @ from_q + b1.T @ (from_dq + grad_dq) + b2.T @ from_ddq
        for basis, centre, half in self._boxes():
            beyond = (basis @ x - centre) / half
            beyond -= np.clip(beyond, -1.0, 1.0)
            value += penalty * float(np.sum(beyond**2)) / FINE
            grad += penalty * 2.0 / FINE * (basis.T @ (beyond / half))
        return value, grad

    def _boxes(self) -> list[tuple[Array, Array, Array]]:
        """(basis, centre, half width) of the limits that are linear in the coefficients."""
        b0, b1, b2 = self.fine
        zero = np.zeros(len(self.joints))
        return [
            (b0, self.room.middle, self.room.half),
            (b1, zero, self.room.velocity),
            (b2, zero, self.room.acceleration),
        ]

    def _torque(self, q: Array, dq: Array, ddq: Array) -> tuple[float, Array | None]:
        """Mean squared excess over the torque limits, and its derivative in the torque."""
        limit = (1 - RESERVE) * self.room.torque
        if not np.isfinite(limit).any():
            return 0.0, None
        tau = self.arm_torque(q, dq, ddq) / limit
        over = tau - np.clip(tau, -1.0, 1.0)
        if not over.any():
            return 0.0, None
        return float(np.sum(over**2)), 2.0 * over / limit

    def repaired(self, x: Array) -> Array:
        """The nearest motion of the same form within position, velocity and acceleration."""
        b0, b1, b2 = self.fine
        x = x.copy()
        speed, rise = np.abs(b1 @ x).max(axis=0), np.abs(b2 @ x).max(axis=0)
        swing = b0[:, 1:] @ x[1:]
        reach = swing.max(axis=0) - swing.min(axis=0)
        with np.errstate(divide="ignore"):
            fit = np.min(
                [
                    self.room.velocity / speed,
                    self.room.acceleration / rise,
                    2 * self.room.half / reach,
                    np.ones(len(speed)),
                ],
                axis=0,
            )
        x[1:] *= fit
        swing = swing * fit
        x[0] = np.clip(
            x[0], self.room.lower - swing.min(axis=0), self.room.upper - swing.max(axis=0)
        )
        return x

    def excess(self, x: Array) -> float:
        """How far torque (share of the limit) and clearance (share of the distance to keep) are
        violated at worst; 0 where the motion can be run as it is."""
        q, dq, ddq = (b @ x for b in self.fine)
        tau = self.arm_torque(q, dq, ddq)
        worst = float(np.max(np.abs(tau) / self.room.torque)) - 1.0
        gaps = self.capsules.clearance(self.whole(q))
        if gaps.size:
            worst = max(worst, float((CLEAR - gaps.min()) / CLEAR))
        return max(worst, 0.0)

    def random(self, rng: np.random.Generator) -> Array:
        """A random motion as large as its limits allow, joint by joint."""
        x = rng.normal(size=self.shape) * self.scale
        x[1:] *= 10.0
        x[0] = self.room.middle + self.room.half * rng.uniform(-1, 1, len(self.joints))
        return self.repaired(x)
