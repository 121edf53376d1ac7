"""What is asked of data: a torque linear in unknowns. Constant; whoever solves it keeps columns,
factors and fits of its own beside it.

Identification streams hours through triangular factors, the search keeps an orthonormal basis in
memory and adds one candidate after the other. Both are given this, and runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from pa10d.model import Term, Unknowns

Array = NDArray[np.float64]
U = TypeVar("U", bound=Unknowns)


@dataclass(frozen=True)
class Knowledge:
    """What is known of the first b unknowns before the data: ‖rows·β - target‖² joins the weighted
    squares; rows (k, b), target (k,).

    spread: (k,) standard deviation of what each row may be off by; one where it counts as it is
    known
    """

    rows: Array
    target: Array
    spread: Array

    @classmethod
    def about(cls, mean: Array, root: Array) -> Knowledge:
        """That β is near ``mean`` (b,): ‖root·(β - mean)‖², root (k, b)."""
        return cls(root, root @ mean, np.ones(len(root)))

    def wide(self, size: int) -> Array:
        """(k, size): its rows as equations for all unknowns."""
        out = np.zeros((len(self.rows), size))
        out[:, : self.rows.shape[1]] = self.rows
        return out

    def beside(self, other: Knowledge, size: int) -> Knowledge:
        """This and another, of ``size`` unknowns."""
        return Knowledge(
            np.concatenate([self.wide(size), other.wide(size)]),
            np.concatenate([self.target, other.target]),
            np.concatenate([self.spread, other.spread]),
        )

    def scatter(self, size: int) -> Array:
        """(size, size) covariance of what it brings to the normal equations of all unknowns."""
        wide = self.wide(size) * self.spread[:, None]
        return np.asarray(wide.T @ wide)


@dataclass(frozen=True)
class LinearProblem(Generic[U]):
    """unknowns   which there are, and where each stands
    prior      what is known of them beforehand (None: nothing but bodies, and how smooth maps are)
    sigma      (n,) N·m: joints are weighted by 1/σ² (None: by what the fit leaves of each)
    bodies     of the base parameters, where they are to stay as far as the data do not say
    """

    unknowns: U
    prior: Knowledge | None = None
    sigma: Array | None = None
    bodies: Knowledge | None = None

    @property
    def terms(self) -> tuple[Term, ...]:
        """The effects among the unknowns."""
        return self.unknowns.terms

    @property
    def known(self) -> Knowledge | None:
        """All that is known besides the data."""
        if self.prior is not None:
            return self.prior
        maps = smoothness(self.unknowns)
        if self.bodies is None or maps is None:
            return self.bodies or maps
        return self.bodies.beside(maps, self.unknowns.size)

    def with_terms(self, terms: Sequence[Term]) -> LinearProblem[U]:
        """The same with other effects, or other shapes of them."""
        return replace(self, unknowns=replace(self.unknowns, terms=tuple(terms)))

    def with_term(self, index: int, term: Term) -> LinearProblem[U]:
        """The same with another effect, or another shape of it, in one place."""
        return self.with_terms([*self.terms[:index], term, *self.terms[index + 1 :]])


def smoothness(unknowns: Unknowns) -> Knowledge | None:
    """Penalties of all terms that have one."""
    rows = []
    for term, place in zip(unknowns.terms, unknowns.places, strict=True):
        penalty = term.effect.penalty(term.shape)
        if penalty is not None:
            rows.append(np.zeros((len(penalty), unknowns.size)))
            rows[-1][:, place] = penalty
    return Knowledge.about(np.zeros(unknowns.size), np.concatenate(rows)) if rows else None
