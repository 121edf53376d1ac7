"""Tall matrices reduced to their triangular factor, piece by piece (TSQR).

A Gram matrix would square the condition number and with it lose half of the digits; the
triangular factor of an orthogonal reduction loses none, and needs no more memory.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Array = NDArray[np.float64]


BLOCK = 64  # columns that LAPACK may reduce at a time: as many as it ever does


@dataclass
class Triangle:
    """R of the rows seen so far: ‖R·x‖ = ‖rows·x‖ for every x; their number and column sums."""

    width: int

    def __post_init__(self) -> None:
        self.r = np.zeros((0, self.width))
        self.sums = np.zeros(self.width)
        self.rows = 0

    def add(self, *parts: Array) -> None:
        """Take in more rows (m, width), in parts (m, k) or (m,) that stand side by side."""
        new = len(parts[0])
        if not new:
            return
        self.rows += new
        known = len(self.r)
        stacked = np.empty((known + new, self.width), order="F")  # as LAPACK wants it: no copy
        stacked[:known] = self.r
        start = 0
        for part in parts:
            wide = part.reshape(new, -1)
            stop = start + wide.shape[1]
            stacked[known:, start:stop] = wide
            self.sums[start:stop] += wide.sum(axis=0)
            start = stop
        if len(stacked) <= self.width:
            self.r = stacked
            return
        work = BLOCK * self.width
        factor = scipy.linalg.lapack.dgeqrf(stacked, lwork=work, overwrite_a=True)[0]
        self.r = np.triu(factor[: self.width])

    def without(self, columns: slice) -> Triangle:
        """The same rows with some columns left out."""
        kept = Triangle(len(np.delete(self.sums, columns)))
        kept.r, kept.rows = np.delete(self.r, columns, axis=1), self.rows
        kept.sums = np.delete(self.sums, columns)
        return kept

    @staticmethod
    def joined(parts: Sequence[Triangle]) -> Triangle:
        """Of all rows that the parts have seen."""
        whole = Triangle(parts[0].width)
        for part in parts:
            rows, sums = whole.rows + part.rows, whole.sums + part.sums
            whole.add(part.r)
            whole.rows, whole.sums = rows, sums
        return whole

    def squares(self, x: Array) -> float:
        """Sum of squares of rows · x."""
        return float(np.sum((self.r @ x) ** 2))


def left_over(r: Array, given: int) -> Array:
    """Triangular factor of the columns after ``given`` ones, as those leave them over.

    r: (≥ width, width) upper triangular; its lower right corner is that factor.
    """
    return r[given:, given:]


def min_norm(r: Array, extra: Array) -> Array:
    """Coefficients (k+1,) of [columns, extra column] for the torque, from r = [R, z] of [columns,
    torque] and the extra column's share ``extra`` in the same rotated rows."""
    matrix = np.column_stack([r[:, :-1], extra])
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    return np.asarray(scipy.linalg.lstsq(matrix / scale, r[:, -1], cond=1e-9)[0] / scale)
