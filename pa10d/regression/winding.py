"""How the links behind springs swing when a recording begins, as its own torque tells.

Nobody waits until a link with little damping has come to rest before the recorder is started, and
from a wrong beginning it swings on for seconds: K 60 kN·m/rad under 45 kg·m² with 2 % of damping
keeps a tenth of it for three seconds and more. What a link does by itself is linear in where it
begins and how fast (two homogeneous solutions of its equation), so both are fitted to the run, as
the initial state always is where a model with memory is judged on a record (Ljung, *System
Identification*, 1999, section 3.2), and no farther than the motor's torque can have wound it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.effects import Context
from pa10d.effects.rotor import typical_link
from pa10d.effects.swing import swung_freely
from pa10d.effects.twist import springs_of
from pa10d.model import Term, TorqueModel
from pa10d.regression.equation import RunEquation

Array = NDArray[np.float64]
Wound = dict[int, tuple[float, float]]

ROUNDS = 4  # a link that swings far does so beyond first order
AS_IT_IS = 0.003  # of what is left over: a step that changes no more is not taken


def seen_by(model: TorqueModel, run: RunEquation) -> Context:
    """A run's motion with the model's loads and torque; links behind its springs swing at the
    beginning as the samples that count say."""
    springs = [term for term in model.terms if term.effect.series_spring]
    if not springs:
        return model.contextualise(run.context)
    wound: Wound = {term.joints[0]: (0.0, 0.0) for term in springs}
    seen = model.contextualise(run.context.with_wound(wound))
    for _ in range(ROUNDS):
        error = run.driven - run.filtered(model.sensed(seen))
        steps, taken = _steps(springs, seen, run, error)
        if taken < AS_IT_IS:
            break
        wound = {
            j: (more + float(step[0]), rate + float(step[1]))
            for (j, (more, rate)), step in zip(wound.items(), steps, strict=True)
        }
        seen = model.contextualise(run.context.with_wound(wound), seen)
    return seen


def winds(run: RunEquation, joint: int) -> float:
    """N·m, RMS: no more is wound up in a joint's spring when a run begins than its motor winds up
    during that run, give or take."""
    return float(np.sqrt(np.mean(run.raw_tau[:, joint] ** 2)))


def _steps(
    springs: Sequence[Term], seen: Context, run: RunEquation, error: Array
) -> tuple[Array, float]:
    """(springs, 2) N·m and N·m/s that take most of an error (M, n), each joint weighted by what it
    has of that, and each no larger than is likely; and how much they take, RMS in parts of it."""
    sizes = []
    for term in springs:
        j = term.joints[0]
        omega = np.sqrt(term.shape["K"] / typical_link(seen, j, term.shape.get("rotor", 0.0)))
        sizes += [winds(run, j), winds(run, j) * float(omega)]
    shares = [float(term.coefficients[0]) for term in springs]
    slopes = swung_freely(seen, springs_of(seen), shares).reshape(*seen.q.shape, -1)
    columns = [size * run.filtered(slopes[:, :, k]) for k, size in enumerate(sizes)]
    keep = run.keep
    sigma = np.sqrt(np.sum(np.where(keep, error, 0.0) ** 2, axis=0) / np.maximum(keep.sum(0), 1))
    weight = np.where(keep & (sigma > 0.0), 1.0 / np.maximum(sigma, 1e-300), 0.0)
    a = np.column_stack([(c * weight).ravel() for c in columns])
    b = (error * weight).ravel()
    before = np.array([x for term in springs for x in seen.wound[term.joints[0]]]) / sizes
    found = np.linalg.solve(a.T @ a + np.eye(len(sizes)), a.T @ b - before)
    taken = float(np.sqrt(np.mean((a @ found) ** 2)))
    return np.asarray((found * sizes).reshape(-1, 2)), taken
