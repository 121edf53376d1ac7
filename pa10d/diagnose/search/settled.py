"""A fit of the search in triangular form: what the bodies nearest to it are sought with.

The same rows and weights as the search has, so that possible bodies are the nearest to what was
judged and stored.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.regression.state import State
from pa10d.identify.fit import rms_of
from pa10d.regression.solution import Solution, solve
from pa10d.regression.triangle import Triangle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Settled:
    """Per joint the triangular factors of [columns, torque]; and of what keeps its maps smooth, as
    if it had been measured: as strong beside the joint's noise as the search had it."""

    moving: list[Triangle]
    known: list[Triangle]

    @classmethod
    def of(cls, state: State) -> Settled:
        """Of the fit side with all terms of the state."""
        n, width = state.train.n, len(state.fit.beta) + 1
        moving = [Triangle(width) for _ in range(n)]
        for j, columns in state.matrix(0).items():
            moving[j].add(np.column_stack([columns, state.train.tau[j]]))
        known = [Triangle(width) for _ in range(n)]
        for index, term in enumerate(state.terms):
            penalty = term.effect.penalty(term.shape)
            if penalty is not None:
                rows = np.zeros((len(penalty), width))
                rows[:, state.place(index)] = penalty * state.fit.sigma[term.joints[0]]
                known[term.joints[0]].add(rows)
        return cls(moving, known)

    def solution(self, sigma: Array) -> Solution:
        """sigma: (n,) N·m, the weights of the search."""
        size = self.moving[0].r.shape[1] - 1
        indices = [np.arange(size)] * (2 * len(self.moving))
        return solve([*self.moving, *self.known], indices, size, np.tile(sigma, 2))

    def rms(self, beta: Array) -> Array:
        """(n,) N·m that these values of the coefficients leave on the fit side."""
        return rms_of(self.moving, [np.arange(len(beta))] * len(self.moving), beta)
