"""The observation matrix by which excitation is judged, the same for every room.

Its columns: one numerical base of inertial parameters and rotor inertias (pivoted QR, right-hand
link first), then per joint the friction columns atan(50·q̇)·2/π and q̇. The arctangent stands in for
the sign so that gradients exist (Vuong & Ang 2009, section 2.3). SI units, unweighted, all samples:
32 columns for joints 1-4 of the PA10, 62 for all seven. The condition number is that matrix's in
the 2-norm. It depends on which columns represent the base: the same motion had 35 with pivots and
108 with the unpivoted base in which models are estimated, so both are offered.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.adjoint import regressor_gradient
from pa10d.dynamics.base import parameter_name, random_motion
from pa10d.dynamics.regressor import regressor
from pa10d.dynamics.robot import Robot

Array = NDArray[np.float64]

SIGN_STEEPNESS = 50.0  # s/rad, c in atan(c·q̇)
INDEPENDENT = 1e-5  # of a column's unit norm outside the span of those before


@dataclass(frozen=True)
class ObservationColumns:
    """The columns: inertial (b,) standard parameters, rotor (r,) joints, then 2n of friction."""

    robot: Robot
    inertial: NDArray[np.int64]
    rotor: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.inertial) + len(self.rotor) + 2 * self.robot.n

    def matrix(self, q: Array, dq: Array, ddq: Array) -> Array:
        """(N, n, k): torque of joint i at sample s per unit of parameter k."""
        n, b, r = self.robot.n, len(self.inertial), len(self.rotor)
        out = np.zeros((len(q), n, len(self)))
        out[:, :, :b] = regressor(self.robot, q, dq, ddq, self.inertial)
        out[:, self.rotor, b + np.arange(r)] = ddq[:, self.rotor]
        joints = np.arange(n)
        out[:, joints, b + r + joints] = np.arctan(SIGN_STEEPNESS * dq) * (2 / np.pi)
        out[:, joints, b + r + n + joints] = dq
        return out

    def gradient(
        self, q: Array, dq: Array, ddq: Array, weights: Array, torque: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """∂L/∂q, ∂L/∂q̇, ∂L/∂q̈, (N, n) each, of L = Σ weights·matrix (+ Σ torque·τ).

        weights (N, n, k); torque (N, n) weighs the rigid torque of the robot's own parameters.
        """
        n, b, r = self.robot.n, len(self.inertial), len(self.rotor)
        joints = np.arange(n)
        if torque is None:
            grads = regressor_gradient(self.robot, q, dq, ddq, weights[:, :, :b], self.inertial)
        else:
            full = torque[:, :, None] * self.robot.parameters.reshape(-1)
            full[:, :, self.inertial] += weights[:, :, :b]
            grads = regressor_gradient(self.robot, q, dq, ddq, full)
        grad_q, grad_dq, grad_ddq = grads
        grad_ddq[:, self.rotor] += weights[:, self.rotor, b + np.arange(r)]
        slope = SIGN_STEEPNESS / (1.0 + (SIGN_STEEPNESS * dq) ** 2) * (2 / np.pi)
        grad_dq += weights[:, joints, b + r + joints] * slope
        grad_dq += weights[:, joints, b + r + n + joints]
        return grad_q, grad_dq, grad_ddq

    def joint_of(self) -> NDArray[np.int64]:
        """(k,) the joint (0-based) to whose link, rotor or friction each column belongs."""
        joints = np.arange(self.robot.n)
        return np.concatenate([self.inertial // 10, self.rotor, joints, joints])

    def names(self) -> list[str]:
        """What the columns stand for, joints numbered from 1."""
        n = range(1, self.robot.n + 1)
        return [
            *(parameter_name(int(k)) for k in self.inertial),
            *(f"Ia{j + 1}" for j in self.rotor),
            *(f"Fc{j}" for j in n),
            *(f"Fv{j}" for j in n),
        ]


def observation_columns(robot: Robot, samples: int = 300, seed: int = 1) -> ObservationColumns:
    """The columns of a robot, from random motion: of each link, its rotor included, always the one
    with the most that is new."""
    return _columns(robot, samples, seed, pivoted=True)


def model_columns(robot: Robot, samples: int = 300, seed: int = 1) -> ObservationColumns:
    """The same space by the columns that ``base_parameters`` keeps."""
    return _columns(robot, samples, seed, pivoted=False)


def change_of_base(
    source: ObservationColumns, target: ObservationColumns, samples: int = 300, seed: int = 2
) -> Array:
    """(k, k) such that source's matrix @ it = target's, for every motion."""
    motion = random_motion(source.robot, samples, seed)
    old = source.matrix(*motion).reshape(-1, len(source))
    new = target.matrix(*motion).reshape(-1, len(target))
    exact = np.asarray(np.linalg.lstsq(old, new, rcond=None)[0], dtype=float)
    exact[np.abs(exact) < 1e-10] = 0.0
    return exact


def condition_number(robot: Robot, q: Array, dq: Array, ddq: Array) -> float:
    """2-norm condition number of the observation matrix of a motion, q, dq, ddq (N, n)."""
    columns = observation_columns(robot)
    return float(np.linalg.cond(columns.matrix(q, dq, ddq).reshape(-1, len(columns))))


def _columns(robot: Robot, samples: int, seed: int, pivoted: bool) -> ObservationColumns:
    n = robot.n
    q, dq, ddq = random_motion(robot, samples, seed)
    whole = np.zeros((samples, n, n, 11))
    whole[..., :10] = regressor(robot, q, dq, ddq).reshape(samples, n, n, 10)
    for j in range(n):
        whole[:, j, j, 10] = ddq[:, j]
    kept = np.sort(_independent(whole.reshape(samples * n, 11 * n), pivoted))
    link, place = np.divmod(kept, 11)
    return ObservationColumns(robot, (10 * link + place)[place < 10], link[place == 10])


def _independent(table: Array, pivoted: bool) -> NDArray[np.int64]:
    """Eleven columns per link, taken link by link from the right."""
    norms = np.linalg.norm(table, axis=0)
    basis, kept = np.empty((len(table), 0)), []
    for link in reversed(range(table.shape[1] // 11)):
        left = [c for c in range(11 * link, 11 * link + 11) if norms[c] > 1e-13 * norms.max()]
        while left:
            rest = table[:, left]
            for _ in range(2):  # twice is enough (Kahan)
                rest = rest - basis @ (basis.T @ rest)
            size = np.linalg.norm(rest, axis=0)
            new = size > INDEPENDENT * norms[left]
            if not new.any():
                break
            # equal columns (a rotor and its link's own inertia) tie: the first one, always
            largest = new & (size * (1 + 1e-9) >= size[new].max()) if pivoted else new
            first = int(np.argmax(largest))
            basis = np.column_stack([basis, rest[:, first] / size[first]])
            kept.append(left.pop(first))
    return np.array(kept, dtype=np.int64)
