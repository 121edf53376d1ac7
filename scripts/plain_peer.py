"""Identification as a textbook has it, from Pinocchio, NumPy and SciPy alone: a bare reference.

Pinocchio's torque regressor sample by sample, every column and the torque decimated alike, base
columns by QR with pivoting, least squares weighted by joint, standard errors of white noise. No
search for a friction sign's sharpness or a timing shift, no bodies that can exist. One thread.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import scipy
from threadpoolctl import threadpool_limits

FACTOR = 10  # samples that become one
SIGN = 50.0  # s/rad, of 2/π·atan(SIGN·q̇)
DEPENDENT = 1e-6  # of the largest diagonal of R


@threadpool_limits.wrap(limits=1, user_api="blas")
def identify(robot: Any, data: Any) -> tuple[np.ndarray, np.ndarray]:
    """Base parameters (p,) and their standard errors (p,) from q, q̇, q̈, τ (N, n) each."""
    model, order = robot.pinocchio()
    n, samples = model.nv, len(data.q)
    workspace = model.createData()
    q, dq, ddq = (np.ascontiguousarray(x[:, order]) for x in (data.q, data.dq, data.ddq))
    rows = np.zeros((samples, n, 13 * n))
    for k in range(samples):
        rows[k, :, : 10 * n] = pin.computeJointTorqueRegressor(
            model, workspace, q[k], dq[k], ddq[k]
        )
    for j in range(n):
        rows[:, j, 10 * n + j] = ddq[:, j]
        rows[:, j, 11 * n + j] = 2 / np.pi * np.arctan(SIGN * dq[:, j])
        rows[:, j, 12 * n + j] = dq[:, j]
    used = np.flatnonzero(np.any(rows.reshape(-1, 13 * n), axis=0))
    columns = scipy.signal.decimate(rows[:, :, used], FACTOR, axis=0)
    tau = scipy.signal.decimate(data.tau[:, order], FACTOR, axis=0)
    flat = columns.reshape(-1, len(used))
    r, pivots = scipy.linalg.qr(flat, mode="r", pivoting=True)
    size = np.abs(np.diag(r))
    base = np.sort(pivots[: int(np.sum(size > DEPENDENT * size[0]))])
    error = tau - (flat[:, base] @ np.linalg.lstsq(flat[:, base], tau.ravel())[0]).reshape(-1, n)
    sigma = np.std(error, axis=0)
    weighted = (columns[:, :, base] / sigma[:, None]).reshape(-1, len(base))
    solved = np.linalg.lstsq(weighted, (tau / sigma).ravel())[0]
    return solved, np.sqrt(np.diag(np.linalg.inv(weighted.T @ weighted)))
