"""What was found, in figures for a person and for a file."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.trajectory.excitation.criterion import joint_errors
from pa10d.trajectory.excitation.problem import ExcitationProblem

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LimitUse:
    """How much of each limit a motion takes, per joint; the limits are those of planning."""

    position: list[float]
    velocity: list[float]
    acceleration: list[float]
    torque: list[float]


@dataclass(frozen=True)
class ExcitationFigures:
    """Everything by which a motion can be judged; joints in the order of ``problem.joints``.

    condition_number is INTERFACES' one; ``_model_base``: in the columns of estimated models,
    ``_scaled``: columns to unit norm, ``_weighted``: rows divided by the criterion's noise,
    ``_above_boundary``: only rows of joints above the boundary velocity; None where the criterion
    has no noise or boundary.
    standard_error: RMS over a joint's own parameters, SI, at 1 N·m of white noise per sample.
    clearance: m between bodies, None where nothing could be met.
    """

    condition_number: float
    condition_number_model_base: float
    condition_number_scaled: float
    smallest_singular_value: float
    log_det: float
    columns: int
    equations: int
    standard_error: list[float]
    evenness: float
    use: LimitUse
    clearance: float | None
    condition_number_weighted: float | None = None
    share_above_boundary: list[float] | None = None
    condition_number_above_boundary: float | None = None

    def document(self) -> JsonObject:
        """As JSON: what the criterion did not ask for is left out."""
        told = asdict(self)
        for asked in ("condition_number_weighted", "share_above_boundary",
                      "condition_number_above_boundary"):  # fmt: skip
            if told[asked] is None:
                del told[asked]
        return told


def figures(problem: ExcitationProblem, x: Array) -> ExcitationFigures:
    """Of a motion, by its coefficients."""
    q, dq, ddq = problem.motion(x)
    table = problem.columns.matrix(q, dq, ddq)
    whole = table.reshape(-1, table.shape[2])
    values = np.linalg.svd(whole, compute_uv=False)
    covariance = np.asarray(np.linalg.inv(whole.T @ whole), dtype=float)
    errors = joint_errors(covariance, problem.columns.joint_of())
    change = problem.bases.change
    noise, boundary = problem.criterion.noise, problem.criterion.boundary
    weighted = None if noise is None else _cond((table / noise[:, None]).reshape(whole.shape))
    above = None if boundary is None else np.abs(dq) > boundary
    use, clearance = _use(problem, x)
    return ExcitationFigures(
        condition_number=float(values[0] / values[-1]),
        condition_number_model_base=_cond(whole if change is None else whole @ change),
        condition_number_scaled=_cond(whole / np.linalg.norm(whole, axis=0)),
        smallest_singular_value=float(values[-1]),
        log_det=float(2 * np.sum(np.log(values))),
        columns=int(whole.shape[1]),
        equations=int(whole.shape[0]),
        standard_error=errors.tolist(),
        evenness=float(errors.max() / errors.min()),
        use=use,
        clearance=clearance,
        condition_number_weighted=weighted,
        share_above_boundary=None if above is None else above.mean(axis=0).tolist(),
        condition_number_above_boundary=None if above is None else _cond(table[above]),
    )


def _cond(matrix: Array) -> float:
    return float(np.linalg.cond(matrix)) if len(matrix) >= matrix.shape[1] else float("inf")


def _use(problem: ExcitationProblem, x: Array) -> tuple[LimitUse, float | None]:
    q, dq, ddq = (basis @ x for basis in problem.fine)
    tau = problem.arm_torque(q, dq, ddq)
    room = problem.room
    gaps = problem.capsules.clearance(problem.whole(q))
    use = LimitUse(
        position=(np.abs(q - room.middle).max(axis=0) / room.half).tolist(),
        velocity=(np.abs(dq).max(axis=0) / room.velocity).tolist(),
        acceleration=(np.abs(ddq).max(axis=0) / room.acceleration).tolist(),
        torque=(np.abs(tau).max(axis=0) / room.torque).tolist(),
    )
    return use, float(gaps.min()) if gaps.size else None
