"""The part of a torque model that the loop evaluates itself, in every cycle.

Rigid bodies at the measured position and speed; rotor inertia, Coulomb and viscous friction and
offset at the desired motion (paper, 3.2.2). Everything else that the model predicts travels with
a motion, computed along it beforehand (see ``remainder``), so that effects with memory and effects
of third parties need no second implementation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.effects import Context
from pa10d.model import TorqueModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LiveModel:
    """rigid (n, 10); the others (n,): kg·m², N·m, rad/s, N·m·s/rad, N·m."""

    name: str
    rigid: Array
    rotor: Array
    coulomb: Array
    v0: Array
    viscous: Array
    offset: Array

    def torque(self, robot: Robot, q: Array, dq: Array, desired: Array, ddq: Array) -> Array:
        """(N, n) N·m at q, dq; friction at the ``desired`` speed; ddq the desired acceleration."""
        out = inverse_dynamics(robot, self.rigid, q, dq, ddq)
        out += self.rotor * ddq + self.viscous * desired + self.offset
        out += self.coulomb * np.tanh(desired / self.v0)
        return out

    def document(self) -> dict[str, Any]:
        """For the pipe to the control process."""
        arrays = {k: v.tolist() for k, v in vars(self).items() if k != "name"}
        return {"name": self.name, **arrays}

    @staticmethod
    def from_document(document: dict[str, Any]) -> LiveModel:
        """The other way."""
        arrays = {k: np.array(v, dtype=float) for k, v in document.items() if k != "name"}
        return LiveModel(name=document["name"], **arrays)


def live_model(model: TorqueModel) -> LiveModel:
    """The loop's part; a feasible parameter set is preferred, because its inertia is positive."""
    n = model.robot.n
    rotor, coulomb, viscous, offset = (np.zeros(n) for _ in range(4))
    v0 = np.full(n, 0.01)
    linear = {"rotor_inertia": rotor, "viscous": viscous, "torque_offset": offset}
    for term in model.terms:
        if term.effect_id in linear:
            linear[term.effect_id][term.joints[0]] += term.coefficients[0]
        elif term.effect_id == "coulomb" and not coulomb[term.joints[0]]:
            coulomb[term.joints[0]] = term.coefficients[0]
            v0[term.joints[0]] = term.shape["v0"]
    rigid = model.standard if model.feasible and model.standard is not None else model.rigid
    return LiveModel(model.name, np.array(rigid), rotor, coulomb, v0, viscous, offset)


def remainder(
    model: TorqueModel, live: LiveModel, q: Array, dq: Array, ddq: Array, dt: float
) -> Array:
    """(N, n) N·m: what the whole model predicts along a desired motion beyond ``live``."""
    context = Context(
        robot=model.robot,
        t=np.arange(float(len(q))) * dt,
        q=q,
        dq=dq,
        ddq=ddq,
        rigid=model.rigid,
        total=np.zeros_like(q),
        desired=True,
    )
    whole = model.predict(context)
    for term in model.terms:
        if not term.effect.commanded:
            whole = whole - term.torque(model.contextualise(context))
    return whole - live.torque(model.robot, q, dq, dq, ddq)
