"""What was found, in figures for a person and for a file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.trajectory.excitation.criterion import joint_errors
from pa10d.trajectory.excitation.problem import ExcitationProblem

Array = NDArray[np.float64]


def figures(problem: ExcitationProblem, x: Array) -> dict[str, Any]:
    """Everything by which a motion can be judged; joints in the order of ``problem.joints``.

    condition_number is INTERFACES' one; ``_model_base``: in the columns of estimated models,
    ``_scaled``: columns to unit norm, ``_weighted``: rows divided by the criterion's noise,
    ``_above_boundary``: only rows of joints above the boundary velocity.
    standard_error: RMS over a joint's own parameters, SI, at 1 N·m of white noise per sample.
    """
    q, dq, ddq = problem.motion(x)
    table = problem.columns.matrix(q, dq, ddq)
    whole = table.reshape(-1, table.shape[2])
    values = np.linalg.svd(whole, compute_uv=False)
    covariance = np.asarray(np.linalg.inv(whole.T @ whole), dtype=float)
    errors = joint_errors(covariance, problem.columns.joint_of())
    change = problem.bases.change
    out: dict[str, Any] = {
        "condition_number": float(values[0] / values[-1]),
        "condition_number_model_base": _cond(whole if change is None else whole @ change),
        "condition_number_scaled": _cond(whole / np.linalg.norm(whole, axis=0)),
        "smallest_singular_value": float(values[-1]),
        "log_det": float(2 * np.sum(np.log(values))),
        "columns": int(whole.shape[1]),
        "equations": int(whole.shape[0]),
        "standard_error": errors.tolist(),
        "evenness": float(errors.max() / errors.min()),
        **_use(problem, x),
    }
    criterion = problem.criterion
    if criterion.noise is not None:
        rows = (table / criterion.noise[:, None]).reshape(whole.shape)
        out["condition_number_weighted"] = _cond(rows)
    if criterion.boundary is not None:
        above = np.abs(dq) > criterion.boundary
        out["share_above_boundary"] = above.mean(axis=0).tolist()
        out["condition_number_above_boundary"] = _cond(table[above])
    return out


def _cond(matrix: Array) -> float:
    return float(np.linalg.cond(matrix)) if len(matrix) >= matrix.shape[1] else float("inf")


def _use(problem: ExcitationProblem, x: Array) -> dict[str, Any]:
    """How much of each limit the motion takes, per joint; the limits are those of planning."""
    q, dq, ddq = (basis @ x for basis in problem.fine)
    tau = problem.arm_torque(q, dq, ddq)
    room = problem.room
    gaps = problem.capsules.clearance(problem.whole(q))
    return {
        "use": {
            "position": (np.abs(q - room.middle).max(axis=0) / room.half).tolist(),
            "velocity": (np.abs(dq).max(axis=0) / room.velocity).tolist(),
            "acceleration": (np.abs(ddq).max(axis=0) / room.acceleration).tolist(),
            "torque": (np.abs(tau).max(axis=0) / room.torque).tolist(),
        },
        "clearance": float(gaps.min()) if gaps.size else None,
    }
