"""The vector of unknowns of a linear model: what stands where in it, and what each is called."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import BaseParameters
from pa10d.dynamics.base import parameter_name
from pa10d.model.term import Term

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Unknowns:
    """b base parameters, then the coefficients of every term: a coefficient vector β (p,)."""

    base: BaseParameters
    terms: tuple[Term, ...]

    @cached_property
    def places(self) -> tuple[slice, ...]:
        """Per term: where its coefficients stand."""
        ends = len(self.base) + np.cumsum([0, *(t.width for t in self.terms)])
        return tuple(slice(int(a), int(b)) for a, b in pairwise(ends))

    @property
    def size(self) -> int:
        """How many there are, p."""
        return self.places[-1].stop if self.terms else len(self.base)

    def names(self) -> list[str]:
        """``Izz4``, ``coulomb J2: Fc`` …"""
        names = [parameter_name(k) for k in self.base.kept]
        for term in self.terms:
            names += [term.named(c.name) for c in term.effect.coefficients]
        return names

    def owners(self) -> list[tuple[int, ...]]:
        """0-based joint(s) that each belongs to: the link's, or the effect's."""
        out: list[tuple[int, ...]] = [(int(k) // 10,) for k in self.base.kept]
        for term in self.terms:
            out += [term.joints] * term.width
        return out

    def rigid(self, beta: Array) -> Array:
        """(b,) base parameters of β."""
        return beta[: len(self.base)].copy()

    def fitted(self, beta: Array) -> tuple[Term, ...]:
        """The terms with their coefficients from β."""
        return tuple(
            replace(term, coefficients=beta[place].copy())
            for term, place in zip(self.terms, self.places, strict=True)
        )


def vector_of(h: Array, terms: Sequence[Term]) -> Array:
    """β (p,) of base parameters (b,) and fitted terms."""
    return np.concatenate([h, *(term.coefficients for term in terms)])
