"""The coefficients that a model is stored with: fitted as identification fits them.

A search leaves reversals out, because sticking there imitates many effects, and lets joints that
fit well speak louder, because that finds small effects. A model that is to predict torque is
fitted to all motion and weighted as the given model was, or its errors would not compare.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.state import State
from pa10d.identify.fit import rms_of
from pa10d.identify.solution import Solution, estimate_weights, solve
from pa10d.identify.triangle import Triangle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Settled:
    """Per joint the triangular factors of [columns, torque] in motion and at rest; and of what
    keeps its maps smooth, as if it had been measured: as strong beside the joint's noise as the
    search had it."""

    moving: list[Triangle]
    rest: list[Triangle]
    known: list[Triangle]

    @classmethod
    def of(cls, state: State) -> Settled:
        """Of the fit side with all terms of the state."""
        n, width = state.train.n, len(state.fit.beta) + 1
        moving, rest = ([Triangle(width) for _ in range(n)] for _ in range(2))
        for k, (run, columns) in enumerate(zip(state.train.runs, _columns(state), strict=True)):
            still = run.inside[:, None] & ~run.moving
            for j in range(n):
                rows = np.column_stack([columns[:, j], state.train.runs[k].tau[:, j]])
                moving[j].add(rows[run.moving[:, j]])
                rest[j].add(rows[still[:, j]])
        known = [Triangle(width) for _ in range(n)]
        for index, term in enumerate(state.terms):
            penalty = term.effect.penalty(term.shape)
            if penalty is not None:
                rows = np.zeros((len(penalty), width))
                rows[:, state.place(index)] = penalty * state.fit.sigma[term.joints[0]]
                known[term.joints[0]].add(rows)
        return cls(moving, rest, known)

    def solution(self, count: int) -> Solution:
        """Of the model with the first ``count`` columns only."""
        factors, still, known = (
            [t.without(np.s_[count:-1]) for t in side]
            for side in (self.moving, self.rest, self.known)
        )
        indices = [np.arange(count)] * len(factors)
        sigma = estimate_weights(factors, still, indices, count)
        found = solve([*factors, *known], [*indices, *indices], count, np.tile(sigma, 2))
        return replace(found, sigma=sigma)

    def rms(self, beta: Array) -> Array:
        """(n,) N·m that these values of the first coefficients leave in motion."""
        moving = [t.without(np.s_[len(beta) : -1]) for t in self.moving]
        return rms_of(moving, [np.arange(len(beta))] * len(moving), beta)


def _columns(state: State) -> Iterator[Array]:
    """Per run (M, n, p): every column of the state's model."""
    side = state.train
    rigid = side.rigid_of_runs(state.model.base.kept)
    effects = [side.columns_of_runs(t.effect, t.joints, t.shape) for t in state.terms]
    for k, columns in enumerate(rigid):
        yield np.concatenate([columns, *[e[k] for e in effects]], axis=-1)
