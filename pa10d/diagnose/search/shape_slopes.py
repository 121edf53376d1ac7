"""How the torque of a model moves with the shapes of its terms, beyond what coefficients absorb."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.regression.shapes import free_shapes
from pa10d.diagnose.regression.slopes import with_slopes
from pa10d.diagnose.regression.state import SearchState
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]


def shape_slopes(state: SearchState) -> PerJoint:
    """joint -> (m_j, s) weighted: how the torque of all terms beyond dry friction moves with their
    shapes, beyond what coefficients absorb. They were settled beside what is asked for now, and may
    stand in for it."""
    fit, train = state.fit, state.train
    parts: dict[int, list[Array]] = {j: [] for j in range(train.n)}
    for term in state.terms:
        if not free_shapes(term.effect, term.shape):
            continue
        count, moved = len(term.coefficients), with_slopes(train, term)
        width = next(iter(moved.values())).shape[1] - count
        for j in range(train.n):
            own = moved[j][:, count:] if j in moved else np.zeros((len(fit.basis[j]), width))
            parts[j].append(own / fit.sigma[j])
    columns = {j: np.column_stack([fit.basis[j][:, :0], *own]) for j, own in parts.items()}
    return beyond(fit.basis, columns)


def beyond(basis: PerJoint, columns: PerJoint) -> PerJoint:
    """Columns (m_j, k) without what an orthonormal basis has of them over all joints."""
    seen = np.sum([basis[j].T @ columns[j] for j in columns], axis=0)
    return {j: columns[j] - basis[j] @ seen for j in columns}
