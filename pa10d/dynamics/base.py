"""Base parameters: the combinations of standard parameters that torque can reveal.

Found numerically (Gautier 1991): columns of a regressor over random motions are taken from the
right-hand link inwards; a column that depends on those already taken is dropped and its
parameter is regrouped into theirs, h_b = h_kept + K·h_dropped.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics.regressor import regressor
from pa10d.dynamics.robot import PARAMETER_NAMES, Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BaseParameters:
    """kept (b,) and dropped (10n-b,): indices into the standard parameters, link-major.

    relations (b, 10n-b): h_b = h[kept] + relations @ h[dropped]
    gap: (smallest pivot kept, largest pivot dropped), column-scaled; the rank is decided
    between them, and they lie many decades apart when it is clear
    """

    kept: NDArray[np.int64]
    dropped: NDArray[np.int64]
    relations: Array
    gap: tuple[float, float]

    def __len__(self) -> int:
        return len(self.kept)

    def of(self, standard: Array) -> Array:
        """Base parameters (b,) of standard parameters (n, 10) or (10n,)."""
        flat = np.asarray(standard, dtype=float).reshape(-1)
        return flat[self.kept] + self.relations @ flat[self.dropped]

    def matrix(self) -> Array:
        """(b, 10n) such that h_b = matrix @ h."""
        total = len(self.kept) + len(self.dropped)
        out = np.zeros((len(self.kept), total))
        out[np.arange(len(self.kept)), self.kept] = 1.0
        out[:, self.dropped] = self.relations
        return out

    def sentences(self, tolerance: float = 1e-9) -> list[str]:
        """The regroupings in words, such as ``mx2 + 0.45·m3``, one per base parameter."""
        lines = []
        for row, kept in enumerate(self.kept):
            terms = [parameter_name(kept)]
            for column, dropped in enumerate(self.dropped):
                factor = self.relations[row, column]
                if abs(factor) > tolerance:
                    sign = "+" if factor > 0 else "-"
                    size = "" if abs(abs(factor) - 1) < tolerance else f"{abs(factor):.6g}·"
                    terms.append(f"{sign} {size}{parameter_name(dropped)}")
            lines.append(" ".join(terms))
        return lines


def parameter_name(index: int) -> str:
    """``Ixx3`` for the index of a standard parameter (links numbered from 1)."""
    return f"{PARAMETER_NAMES[index % 10]}{index // 10 + 1}"


def parameter_unit(name: str) -> str:
    """Of a standard parameter by name: ``Izz4``, ``mx2``, ``m3``."""
    return "kg·m²" if name[0] == "I" else "kg·m" if name[1] in "xyz" else "kg"


def base_parameters(robot: Robot, samples: int = 300, seed: int = 1) -> BaseParameters:
    """The structural base of a robot: what any motion could identify at best."""
    q, dq, ddq = random_motion(robot, samples, seed)
    return reduce_columns(regressor(robot, q, dq, ddq).reshape(-1, 10 * robot.n))


def reduce_columns(matrix: Array, tolerance: float = 1e-4) -> BaseParameters:
    """Base of a matrix (rows, 10n): greedy from the right-hand link, column-scaled.

    A column is kept where, of its unit norm, more than ``tolerance`` lies outside the span of
    the columns kept before. On exact regressors the two groups are ~10 decades apart; a URDF
    that rounds a right angle to 1.5708 fills the gap with pivots up to 3e-5 that no measurement
    could use, hence the tolerance.
    """
    if matrix.shape[0] > matrix.shape[1]:  # lengths and angles of columns are those of the factor
        matrix = np.asarray(np.linalg.qr(matrix, mode="r"))
    total = matrix.shape[1]
    order = [10 * link + k for link in reversed(range(total // 10)) for k in range(10)]
    norms = np.linalg.norm(matrix, axis=0)
    largest = norms.max() if norms.size else 0.0
    kept: list[int] = []
    dropped, pivots, rests = [], [], []
    basis = np.empty((total, len(matrix)))  # orthonormal rows, as many as columns are kept
    for c in order:
        if norms[c] <= largest * 1e-13:
            dropped.append(c)
            continue
        unit = matrix[:, c] / norms[c]
        found = basis[: len(kept)]
        rest = unit - found.T @ (found @ unit)
        rest -= found.T @ (found @ rest)  # twice is enough (Kahan)
        size = float(np.linalg.norm(rest))
        if size > tolerance:
            basis[len(kept)] = rest / size
            kept.append(c)
            pivots.append(size)
        else:
            dropped.append(c)
            rests.append(size)
    kept_index, dropped_index = np.sort(kept).astype(np.int64), np.sort(dropped).astype(np.int64)
    scaled = matrix[:, kept_index] / norms[kept_index]
    relations = np.linalg.lstsq(scaled, matrix[:, dropped_index], rcond=None)[0]
    relations /= norms[kept_index, None]
    relations[np.abs(relations) < 1e-10] = 0.0
    gap = (min(pivots, default=0.0), max(rests, default=0.0))
    return BaseParameters(kept_index, dropped_index, relations, gap)


def random_motion(robot: Robot, samples: int, seed: int) -> tuple[Array, Array, Array]:
    """Random states over the whole circle (prismatic: a metre), for structural questions only."""
    rng = np.random.default_rng(seed)
    span = np.where(robot.prismatic, 0.5, np.pi)
    return (
        rng.uniform(-span, span, (samples, robot.n)),
        rng.normal(0.0, 1.5, (samples, robot.n)),
        rng.normal(0.0, 3.0, (samples, robot.n)),
    )
