"""Which experiment would settle a doubt: the one with the largest expected evidence.

Two candidates explain this data alike. For every experiment the arm could run, the torque that
each predicts there is computed; the second one's coefficients and the model's are refitted to
the first one's torque, and what they cannot imitate, over the noise, is the evidence to expect.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.diagnose.constants import LONGEST_PLAN, PLAN_RATE, WORTH_AN_EXPERIMENT
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.diagnose.search.candidates import Candidate
from pa10d.dynamics import regressor
from pa10d.effects import Context
from pa10d.model import Term, TorqueModel
from pa10d.trajectory.kinds import KINDS, Kind, validated
from pa10d.trajectory.poses import Surroundings

Array = NDArray[np.float64]


def settle_doubt(
    model: TorqueModel, first: Candidate, rivals: Sequence[Candidate]
) -> NextExperiment | None:
    """The one that best separates a finding from its rivals; None where nothing would."""
    best: tuple[float, Kind] | None = None
    around = Surroundings.of(model.robot)
    for request in requests(model, first, rivals):
        try:
            plan = request.build(around)
        except UserError:
            continue
        if plan.duration > LONGEST_PLAN:
            continue
        motion = plan.sample(PLAN_RATE)
        context = model.contextualise(
            Context(
                robot=model.robot,
                t=motion.t,
                q=motion.q,
                dq=motion.dq,
                ddq=motion.ddq,
                rigid=model.rigid,
                total=np.zeros_like(motion.q),
            )
        )
        evidence = min(_evidence(model, context, first.term, r.term) for r in rivals)
        if best is None or evidence > best[0]:
            best = (evidence, request)
    if best is None or best[0] < WORTH_AN_EXPERIMENT:
        return None
    evidence, chosen = best
    return NextExperiment(**chosen.request(), apart=float(evidence))


def requests(model: TorqueModel, first: Candidate, rivals: Sequence[Candidate]) -> list[Kind]:
    """Experiments worth trying: those the effects themselves ask for, and the general ones."""
    joints = sorted({j + 1 for c in (first, *rivals) for j in c.joints})
    named = [c.effect.experiment_kind for c in (first, *rivals)]
    kinds = list(dict.fromkeys([*named, "velocity_sweep", "load_sweep", "reversals", "excitation"]))
    out = []
    for name in kinds:
        if name not in KINDS:
            continue
        for parameters in ({"joints": joints} if joints else {}, {}):
            try:
                out.append(validated(KINDS[name], parameters))
            except UserError:
                continue
    return out


def _evidence(model: TorqueModel, context: Context, first: Term, second: Term) -> float:
    """Standard errors by which ``first``'s torque differs from the nearest that the model, its
    bodies included, with ``second`` could make of it."""
    moving = np.abs(context.dq) > 0.01 * np.quantile(np.abs(context.dq), 0.99, axis=0)
    target = first.torque(context) / model.noise
    motion, bodies = (context.q, context.dq, context.ddq), model.base.kept
    columns = [
        regressor(model.robot, *motion, bodies) / model.noise[:, None],
        second.full_columns(context) / model.noise[:, None],
    ]
    for term in model.terms:
        if (term.effect_id, term.joints, term.shape) == (
            first.effect_id,
            first.joints,
            first.shape,
        ):
            continue  # the finding itself: the question is what the model makes of it without
        columns.append(term.full_columns(context) / model.noise[:, None])
    mask = moving.ravel()
    matrix = np.concatenate(columns, axis=2).reshape(-1, sum(c.shape[2] for c in columns))[mask]
    wanted = target.ravel()[mask]
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    left = wanted - matrix @ (np.linalg.lstsq(matrix / scale, wanted, rcond=1e-8)[0] / scale)
    # samples PLAN_RATE apart within the band of the equation count once
    independent = min(1.0, 2.0 * model.cutoff / PLAN_RATE)
    return float(np.sqrt(independent * np.sum(left**2)))
