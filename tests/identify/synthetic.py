"""Arms whose parameters are known: the truth that fits are judged against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pa10d.dynamics import Robot, inverse_dynamics, regressor, robot_from_profile
from pa10d.dynamics.base import random_motion
from pa10d.effects.base import smooth_sign
from pa10d.measurement.recording import Recording
from pa10d.profile import load_profile


@dataclass(frozen=True)
class Truth:
    """A robot with its URDF parameters; rotor inertia, Coulomb and viscous friction (n,)."""

    robot: Robot
    rotor: np.ndarray
    coulomb: np.ndarray
    viscous: np.ndarray
    v0: float = 0.01

    def torque(self, q, dq, ddq) -> np.ndarray:
        sign = np.column_stack([smooth_sign(v, self.v0) for v in dq.T])
        rigid = inverse_dynamics(self.robot, self.robot.parameters, q, dq, ddq)
        return rigid + self.rotor * ddq + self.coulomb * sign + self.viscous * dq

    def values(self, model) -> np.ndarray:
        """The model's [h, coefficients] in truth; rotor inertias that the rigid bodies absorb are
        in the base parameters, where least squares finds them."""
        q, dq, ddq = random_motion(self.robot, 200, seed=9)
        rigid = regressor(self.robot, q, dq, ddq, model.base.kept)
        torque = inverse_dynamics(self.robot, self.robot.parameters, q, dq, ddq)
        fitted = {t.joints[0] for t in model.terms if t.effect_id == "rotor_inertia"}
        for j in set(range(self.robot.n)) - fitted:
            torque[:, j] += self.rotor[j] * ddq[:, j]
        h = np.linalg.lstsq(rigid.reshape(-1, rigid.shape[2]), torque.ravel(), rcond=None)[0]
        known = {"rotor_inertia": self.rotor, "coulomb": self.coulomb, "viscous": self.viscous}
        return np.concatenate([h, [known[t.effect_id][t.joints[0]] for t in model.terms]])


def estimates(model) -> np.ndarray:
    """[h, coefficients] (p,)."""
    return np.concatenate([model.h, *[t.coefficients for t in model.terms]])


def pa10(joints: int) -> Robot:
    """The first joints of the PA10, the others locked."""
    profile = load_profile("pa10-sim")
    changes = {"joints": profile.joints[:joints], "limits": type(profile.limits)()}
    return robot_from_profile(profile.model_copy(update=changes))


def pa10_truth(joints: int, friction: bool = True, v0: float = 0.01) -> Truth:
    size = np.array([1.0, 1.0, 0.5, 0.5, 0.1, 0.1, 0.1])[:joints]
    rubs = 1.0 if friction else 0.0
    return Truth(pa10(joints), 0.5 * size, 8.0 * rubs * size, 12.0 * rubs * size, v0)


def fourier(n: int, seconds: float, rate: float, seed: int = 3, period: float = 4.0):
    """t, q, q̇, q̈ of a periodic motion, derivatives in closed form."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * rate)) / rate
    q, dq, ddq = (np.zeros((len(t), n)) for _ in range(3))
    for j in range(n):
        for k in range(1, 5):
            w = 2 * np.pi * k / period
            a, phase = rng.uniform(0.15, 0.4) / k, rng.uniform(0, 2 * np.pi)
            q[:, j] += a * np.sin(w * t + phase)
            dq[:, j] += a * w * np.cos(w * t + phase)
            ddq[:, j] -= a * w * w * np.sin(w * t + phase)
    return t, q, dq, ddq


def recording(truth: Truth, motion, noise=0.0, name: str = "run") -> Recording:
    t, q, dq, ddq = motion
    return Recording(name, t, q, truth.torque(q, dq, ddq) + noise)
