"""The textbook model fitted to one recording: what several checks judge it by."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.regression.equation import RunEquation
from pa10d.regression.steady import steady_direction

Array = NDArray[np.float64]

BLOCK = 1.0  # s whose residuals are taken as one: longer than any filter remembers


def textbook_columns(run: RunEquation, kept: NDArray[np.int64]) -> Array:
    """(M, n, p): rigid bodies' base parameters ``kept``, and per joint rotor inertia, Coulomb,
    viscous friction, offset."""
    c = run.context
    own = [_own(run, part) for part in (c.ddq, np.sign(c.dq), c.dq, np.ones_like(c.dq))]
    return np.concatenate([run.rigid_columns(kept), *own], axis=2)


def springs(run: RunEquation) -> Array:
    """(M, n, n): a spring of each joint's own."""
    return _own(run, run.context.q)


def _own(run: RunEquation, part: Array) -> Array:
    """(M, n, n): a column per joint for what it does by itself."""
    n = run.context.robot.n
    out = np.zeros((run.lowpass.kept, n, n))
    out[:, range(n), range(n)] = run.lowpass(part)
    return out


def steady_sign(run: RunEquation) -> NDArray[np.bool_]:
    """(M, n) False near a joint's reversals and standstills."""
    c = run.context
    fast = np.quantile(np.abs(c.dq), 0.99, axis=0)
    return np.asarray(np.abs(run.lowpass(steady_direction(c.q, c.dq, fast))) > 0.99)


def blocks_of(run: RunEquation) -> NDArray[np.int64]:
    """(M,) which block of BLOCK seconds a sample lies in."""
    return (run.t / BLOCK).astype(np.int64)


def fit_textbook(
    columns: Array, tau: Array, keep: NDArray[np.bool_], weights: Array
) -> tuple[Array, Array]:
    """Parameters, and an orthonormal basis of what the model can absorb (kept rows)."""
    matrix = (columns * weights[:, None])[keep]
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    u, s, vt = np.linalg.svd(matrix / scale, full_matrices=False)
    sure = s > 1e-8 * s[0]
    inner = (u[:, sure].T @ (tau * weights)[keep]) / s[sure]
    return (vt[sure].T @ inner) / scale, u[:, sure]
