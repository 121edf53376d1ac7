"""What of a model's free fit no arm can have, in words.

An unconstrained fit predicts well and may still have a mass matrix that is not positive definite,
or friction that pushes: a controller or a simulator on it can become unstable.
"""

from __future__ import annotations

import math

import numpy as np

from pa10d.common.words import listed, percent
from pa10d.dynamics.typical import usual_poses
from pa10d.effects.base import fitted
from pa10d.effects.context import posed
from pa10d.model.model import TorqueModel
from pa10d.model.term import in_units_of

REMEDY = "use the feasible parameters (--parameters feasible) where something is to move by it"


def impossible(model: TorqueModel) -> tuple[str, ...]:
    """One line per kind of impossibility; none where the model can exist."""
    robot, said = model.robot, []
    masses = mass_matrices(model)
    lowest, directions = np.linalg.eigh(masses)
    bad = lowest[:, 0] <= 0.0
    if bad.any():
        weight = np.mean(directions[bad, :, 0] ** 2, axis=0)
        joints = [robot.joint_names[j] for j in np.flatnonzero(weight > 0.5 * weight.max())]
        share = percent(float(np.mean(bad)))
        said.append(
            f"the free fit's mass matrix is not positive definite in {share} of all poses: "
            f"{listed(joints)} would speed up against the torque; {REMEDY}"
        )
    for term in model.terms:
        for value, c in zip(term.coefficients, term.effect.coefficients, strict=True):
            if c.lower == 0.0 and value < 0.0:
                told = in_units_of(robot, term, {c.name: fitted(value, math.nan, c.unit)})[c.name]
                unit = told.unit if told.unit != "1" else ""
                said.append(
                    f"{term.named(c.name)} = {value:.3g} {unit}".rstrip()
                    + f" in the free fit, expected at least 0; {REMEDY}"
                )
    return tuple(said)


def mass_matrices(model: TorqueModel) -> np.ndarray:
    """(P, n, n) kg·m² over usual poses, rotors and coupled inertias included: the torque of the
    arm's mechanics per acceleration, from rest."""
    q = usual_poses(model.robot)
    rest = np.zeros_like(q)

    def mechanics(ddq: np.ndarray) -> np.ndarray:
        return model.contextualise(posed(model.robot, q, rest, rest + ddq)).total

    still = mechanics(np.zeros(model.robot.n))
    columns = [mechanics(unit) - still for unit in np.eye(model.robot.n)]
    matrices = np.stack(columns, axis=-1)
    return 0.5 * (matrices + matrices.transpose(0, 2, 1))
