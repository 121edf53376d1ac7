"""What the neighbourhood of reversals does to a term's estimates.

Where a joint turns round it sticks for an instant; its friction is anything then, and the filter
carries some of that beyond the samples that are left out. Beside a large friction even a hundredth
of it outweighs the noise. No residual's spectrum knows that, but leaving out twice as much shows
it: an estimate that moves by more than the lost data explain is off by about as much (Hausman
1978, doi:10.2307/1913827: an efficient estimate against one that trusts less).
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from pa10d.diagnose.constants import BLIND, WIDER
from pa10d.diagnose.regression.partial import column_scale, solve_symmetric
from pa10d.diagnose.regression.state import SearchState
from pa10d.measurement.standstill import standstill
from pa10d.regression.per_joint import PerJoint, gathered

Array = NDArray[np.float64]


def moved_by_reversals(state: SearchState, index: int, slopes: PerJoint, variance: Array) -> Array:
    """(k + s,) squares of what the k coefficients and s shapes of a term are off by, beyond their
    noise, for the samples near reversals.

    slopes: joint -> (m_j, s), of the term's torque; variance (k + s,): of the estimates.
    """
    place, rank = state.place(index), state.fit.to_beta.shape[1]
    width = len(variance) - (place.stop - place.start)
    far = _far_from_standstill(state)
    grams = np.zeros((2, rank + width, rank + width))  # of all samples, and of those far away
    sides = np.zeros((2, rank + width))
    for j, basis in state.fit.basis.items():
        own = slopes[j] / state.fit.sigma[j] if j in slopes else np.zeros((len(basis), width))
        both = np.column_stack([basis, own])
        for i, rows in enumerate((np.ones(len(basis), dtype=bool), far[j])):
            grams[i] += both[rows].T @ both[rows]
            sides[i] += both[rows].T @ state.fit.residual[j][rows]
    if state.problem.known is not None:  # what was known before stays known
        grams[:, :rank, :rank] += np.eye(rank) - grams[0, :rank, :rank]
    to_term = scipy.linalg.block_diag(state.fit.to_beta[place], np.eye(width))
    there, here = (
        to_term @ solve_symmetric(g, s) for g, s in zip(grams[::-1], sides[::-1], strict=True)
    )
    spread = [np.diag(to_term @ _inverse(g) @ to_term.T) for g in grams]
    times = np.full(len(variance), BLIND)  # of a shape that moves nothing
    np.divide(spread[1], spread[0], out=times, where=spread[0] > 0.0)
    lost = variance * np.clip(times - 1.0, 0.0, BLIND)
    tells = (times < BLIND) & (_rank(grams[1]) == _rank(grams[0]))
    return np.asarray(np.where(tells, np.maximum((there - here) ** 2 - lost, 0.0), 0.0))


def _far_from_standstill(state: SearchState) -> dict[int, NDArray[np.bool_]]:
    """joint -> (m_j,) of the training side's rows: which lie far from any standstill."""
    side = state.train
    near = [
        standstill(run.context.dq, run.lowpass.rate, run.lowpass, wider=WIDER) for run in side.runs
    ]
    return {j: ~gathered([n[:, j] for n in near], side.keep, j) for j in range(side.n)}


def _rank(gram: Array) -> int:
    """Directions not lost in rounding, as ``solve_symmetric`` and ``_inverse`` count them."""
    scale = column_scale(gram)
    values = np.linalg.eigvalsh(gram / np.outer(scale, scale))
    return int(np.sum(values > 1e-8 * values[-1]))


def _inverse(gram: Array) -> Array:
    """Pseudo-inverse, directions lost in rounding left out."""
    scale = column_scale(gram)
    return np.asarray(np.linalg.pinv(gram / np.outer(scale, scale), 1e-8, hermitian=True)) / (
        np.outer(scale, scale)
    )
