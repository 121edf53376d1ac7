"""How far an answer depends on which part of the data it is taken from.

A standard error from residuals knows of noise. What a model lacks (play, a spring, friction of
another kind) bends an answer in some stretches more than in others: taken from all data but one
stretch at a time, the answer moves by more than noise would move it (delete-one jackknife; Efron
and Stein 1981, doi:10.1214/aos/1176345462).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pa10d.identify.rows import Rows, triangles_of
from pa10d.regression.triangle import Triangle

Array = NDArray[np.float64]

STRETCHES = 6  # at least, of all data together


def stretches(pieces: Sequence[Rows]) -> list[Rows]:
    """Of each piece as many as make ``STRETCHES`` at least in all."""
    each = max(1, -(-STRETCHES // len(pieces)))
    return [part for rows in pieces for part in _split(rows, each)]


def without_each(
    pieces: Sequence[Rows], answer: Callable[[list[Triangle]], float | Array]
) -> Array:
    """(stretches, …) the answer from all of them but one, by the joints' triangular factors; nan
    where the rest has none."""
    blocks = [triangles_of([part]) for part in stretches(pieces)]
    rest = (
        [Triangle.joined(of_joint) for of_joint in zip(*blocks[:k], *blocks[k + 1 :], strict=True)]
        for k in range(len(blocks))
    )
    return np.array([answer(one) for one in rest])


def moved_by_stretches(without: Array) -> float:
    """Standard error of what ``without_each`` gave; 0 where nothing is known of it."""
    found = without[np.isfinite(without)]
    if len(found) < 2:
        return 0.0
    return float(np.sqrt((len(found) - 1) * np.mean((found - found.mean()) ** 2)))


def _split(rows: Rows, parts: int) -> list[Rows]:
    edges = np.linspace(0, len(rows.tau), parts + 1).round().astype(int)
    cuts = [slice(a, b) for a, b in pairwise(edges) if b > a]
    return [
        Rows([c[s] for c in rows.columns], rows.tau[s], rows.keep[s], rows.rest[s]) for s in cuts
    ]
