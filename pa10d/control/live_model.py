"""The part of a torque model that the loop evaluates itself, in every cycle.

Rigid bodies at the measured position and speed; effects that say so of themselves (rotor inertia,
Coulomb and viscous friction, offset) at the desired motion (paper, 3.2.2). Everything else that
the model predicts travels with a motion, computed along it beforehand (see ``remainder``), so that
effects with memory and effects of third parties need no second implementation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.effects import Context, effect
from pa10d.model import Parameters, TorqueModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LiveEffect:
    """One effect on the m joints (0-based) that have it: coefficients (m, k), shape name -> (m,).

    Its formula sees each joint as a sample of its own, so that one call serves all of them.
    """

    effect_id: str
    joints: tuple[int, ...]
    coefficients: Array
    shape: dict[str, Array]

    def __post_init__(self) -> None:
        """What every cycle would look up again."""
        first, count = self.joints[0], len(self.joints)
        side_by_side = self.joints == tuple(range(first, first + count))
        at = slice(first, first + count) if side_by_side else np.array(self.joints)
        vars(self).update(at=at, columns=effect(self.effect_id).columns)

    def add(self, out: Array, dq: Array, ddq: Array) -> None:
        """Its torque at speeds and accelerations (N, n), added to out (N, n) N·m."""
        at, times, shape = self.at, len(dq), self.shape  # type: ignore[attr-defined]
        if times > 1:
            shape = {name: np.tile(values, times) for name, values in shape.items()}
        instant = _Instant(dq[:, at].reshape(-1, 1), ddq[:, at].reshape(-1, 1))
        columns = self.columns(instant, (0,), shape)  # type: ignore[attr-defined]
        rows = columns.reshape(times, len(self.joints), -1)
        for k in range(rows.shape[2]):
            out[:, at] += rows[:, :, k] * self.coefficients[:, k]


class _Instant:
    """What an effect that the loop evaluates may look at: samples of one joint that stand apart."""

    apart, desired = True, True
    sign, softness = Context.sign, Context.softness

    def __init__(self, dq: Array, ddq: Array) -> None:
        self.dq, self.ddq, self.t = dq, ddq, dq[:, 0]


@dataclass(frozen=True)
class LiveModel:
    """rigid (n, 10) standard parameters; parameters: of which fit, feasible or free; kinematics of
    the robot that it was identified on, see ``kinematics_of``."""

    name: str
    rigid: Array
    parts: tuple[LiveEffect, ...] = ()
    parameters: Parameters = "feasible"
    kinematics: Array | None = None

    def torque(self, robot: Robot, q: Array, dq: Array, desired: Array, ddq: Array) -> Array:
        """(N, n) N·m at q, dq; friction at the ``desired`` speed; ddq the desired acceleration."""
        out = inverse_dynamics(robot, self.rigid, q, dq, ddq)
        for part in self.parts:
            part.add(out, desired, ddq)
        return out

    def document(self) -> JsonObject:
        """For the pipe to the control process."""
        parts = [
            {
                "effect": part.effect_id,
                "joints": list(part.joints),
                "coefficients": part.coefficients.tolist(),
                "shape": {name: values.tolist() for name, values in part.shape.items()},
            }
            for part in self.parts
        ]
        return {
            "name": self.name,
            "rigid": self.rigid.tolist(),
            "parts": parts,
            "parameters": self.parameters,
            "kinematics": None if self.kinematics is None else self.kinematics.tolist(),
        }

    @staticmethod
    def from_document(document: JsonObject) -> LiveModel:
        """The other way."""
        parts = tuple(
            LiveEffect(
                part["effect"],
                tuple(part["joints"]),
                np.array(part["coefficients"], dtype=float),
                {name: np.array(values) for name, values in part["shape"].items()},
            )
            for part in document["parts"]
        )
        rigid = np.array(document["rigid"], dtype=float)
        seen = document.get("kinematics")
        kinematics = None if seen is None else np.array(seen, dtype=float)
        return LiveModel(document["name"], rigid, parts, document["parameters"], kinematics)


def live_model(model: TorqueModel) -> LiveModel:
    """The loop's part, of the feasible parameters where the model has some: their inertia is
    positive, and friction never pushes."""
    chosen = _commanded(model)
    at_work = [term for term in chosen.terms if term.effect.live and term.coefficients.any()]
    parts = []
    for name in dict.fromkeys(term.effect_id for term in at_work):
        waiting = [term for term in at_work if term.effect_id == name]
        while waiting:  # a joint that has it twice has it in two parts
            once = list({term.joints: term for term in reversed(waiting)}.values())[::-1]
            waiting = [term for term in waiting if all(term is not other for other in once)]
            shape = {key: np.array([t.shape[key] for t in once]) for key in once[0].shape}
            joints = tuple(t.joints[0] for t in once)
            parts.append(LiveEffect(name, joints, np.array([t.coefficients for t in once]), shape))
    rigid = chosen.standard if chosen is not model and chosen.standard is not None else model.rigid
    kept: Parameters = "free" if chosen is model else "feasible"
    kinematics = kinematics_of(model.robot)
    return LiveModel(model.name, np.array(rigid), tuple(parts), kept, kinematics)


def kinematics_of(robot: Robot) -> Array:
    """(n, 17): parent, orientation, place and axis of every joint, and whether it slides."""
    n = robot.n
    return np.column_stack(
        [robot.parent, robot.rotation.reshape(n, 9), robot.translation, robot.axis, robot.prismatic]
    ).astype(float)


def remainder(
    model: TorqueModel, live: LiveModel, q: Array, dq: Array, ddq: Array, dt: float
) -> Array:
    """(N, n) N·m: what the whole model predicts along a desired motion beyond ``live``."""
    chosen = model.of(live.parameters)
    context = Context(
        robot=model.robot,
        t=np.arange(float(len(q))) * dt,
        q=q,
        dq=dq,
        ddq=ddq,
        rigid=chosen.rigid,
        total=np.zeros_like(q),
        desired=True,
    )
    whole = chosen.predict(context)
    for term in chosen.terms:
        if not term.effect.commanded:
            whole = whole - term.torque(chosen.contextualise(context))
    return whole - live.torque(model.robot, q, dq, dq, ddq)


def _commanded(model: TorqueModel) -> TorqueModel:
    """The parameters that a controller gets."""
    return model.possible() if model.feasible and model.standard is not None else model
