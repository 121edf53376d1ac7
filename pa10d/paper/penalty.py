"""Feasibility as the paper has it (2.4, eq. 16-17): standard parameters that stay near the
least-squares estimate while their links have positive mass and inertia.

min α1·‖W·X_b - τ‖ + α2·‖X_b - ĥ‖ over X = [h, Fc, Fv …]. Both norms are plain, not squared, so this
is a second-order cone programme; "(m, I) > 0" makes each inertia tensor a semidefinite cone. A
genetic algorithm is not needed, and the optimum is the optimum.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import clarabel
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pa10d.dynamics import BaseParameters
from pa10d.dynamics.feasible import definiteness, pseudo_inertia

Array = NDArray[np.float64]
Rule = Literal["paper", "physical"]

LEAST = 1e-4  # kg, kg·m²: what "greater than zero" means
RIDGE = 1e-6  # of the cost, that keeps what torque cannot know near the prior
_TENSOR = ((0, 0, 4), (0, 1, 5), (1, 1, 6), (0, 2, 7), (1, 2, 8), (2, 2, 9))


@dataclass(frozen=True)
class Penalised:
    """standard (n, 10) parameters, further (k,) rotor inertias and friction; base (b + k,) what
    they amount to; smallest (n,) eigenvalue of each pseudo-inertia in link sizes: > 0 is a body
    that can exist; cost of equation 17; solved: whether the solver says so"""

    standard: Array
    further: Array
    base: Array
    smallest: Array
    cost: float
    solved: bool

    @property
    def feasible(self) -> bool:
        """Whether every link could be made of positive mass."""
        return bool(np.all(self.smallest > 0))


def penalty_fit(
    matrix: Array,
    torque: Array,
    estimate: Array,
    base: BaseParameters,
    prior: Array,
    alpha: tuple[float, float] = (1.0, 1.0),
    rule: Rule = "paper",
) -> Penalised:
    """Equation 17.

    matrix (N, b + k), torque (N,), estimate (b + k,) from least squares; prior (n, 10): where the
    parameters that torque cannot reveal are taken from; rule: "paper" m > 0 and I > 0 about each
    joint's origin; "physical": the pseudo-inertia definite, which alone makes a body possible.
    """
    b, links = len(base), len(prior)
    further = matrix.shape[1] - b
    size = 10 * links + further
    to_base = np.zeros((b + further, size))
    to_base[:b, : 10 * links] = base.matrix()
    to_base[b:, 10 * links :] = np.eye(further)
    triangle = np.asarray(np.linalg.qr(np.column_stack([matrix, torque]), mode="r"))
    rows, cones, sides = _norm(triangle[:, :-1] @ to_base, triangle[:, -1], size, 0)
    more = _norm(to_base, estimate, size, 1)
    anchor = np.eye(size)[: 10 * links]
    still = _norm(anchor, prior.reshape(-1), size, 2)
    blocks = [rows, more[0], still[0]]
    cone_list = [*cones, *more[1], *still[1]]
    side = [sides, more[2], still[2]]
    for link in range(links):
        for matrix_, limit, cone in _positive(link, size, rule):
            blocks.append(matrix_)
            side.append(limit)
            cone_list.append(cone)
    bounds = np.zeros((further, size + 3))
    bounds[:, 10 * links : size] = -np.eye(further)
    blocks.append(bounds)
    side.append(np.zeros(further))
    cone_list.append(clarabel.NonnegativeConeT(further))
    scale = 1.0 / max(float(np.linalg.norm(torque)), 1e-12)
    cost = np.zeros(size + 3)
    cost[size:] = alpha[0] * scale, alpha[1] * scale, RIDGE
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    solver = clarabel.DefaultSolver(
        sp.csc_matrix((size + 3, size + 3)), cost, sp.csc_matrix(np.vstack(blocks)),
        np.concatenate(side), cone_list, settings,
    )  # fmt: skip
    answer = solver.solve()
    x = np.asarray(answer.x)[:size]
    standard = x[: 10 * links].reshape(links, 10)
    found = to_base @ x
    value = alpha[0] * np.linalg.norm(matrix @ found - torque)
    value += alpha[1] * np.linalg.norm(found - estimate)
    solved = str(answer.status) in ("Solved", "AlmostSolved")
    return Penalised(standard, x[10 * links :], found, definiteness(standard), float(value), solved)


def _norm(matrix: Array, target: Array, size: int, slot: int) -> tuple[Array, list, Array]:
    """‖matrix·x - target‖ ≤ x[size + slot]."""
    rows = np.zeros((len(matrix) + 1, size + 3))
    rows[0, size + slot] = -1.0
    rows[1:, :size] = -matrix
    return rows, [clarabel.SecondOrderConeT(len(rows))], np.concatenate([[0.0], -target])


def _positive(link: int, size: int, rule: Rule) -> list[tuple[Array, Array, object]]:
    """Rows, sides and cones that keep one link possible."""
    at = 10 * link
    if rule == "physical":
        unit = pseudo_inertia(np.eye(10))
        rows, side = _triangle(unit, at, size, LEAST * 1e-2)
        return [(rows, side, clarabel.PSDTriangleConeT(4))]
    mass = np.zeros((1, size + 3))
    mass[0, at] = -1.0
    tensors = np.zeros((10, 3, 3))
    for i, j, k in _TENSOR:
        tensors[k, i, j] = tensors[k, j, i] = 1.0
    rows, side = _triangle(tensors, at, size, LEAST)
    return [
        (mass, np.array([-LEAST]), clarabel.NonnegativeConeT(1)),
        (rows, side, clarabel.PSDTriangleConeT(3)),
    ]


def _triangle(unit: Array, at: int, size: int, least: float) -> tuple[Array, Array]:
    """Upper triangle, column by column, off-diagonals times √2, of Σ x_k·unit_k - least·1."""
    order = unit.shape[1]
    places = [(i, j) for j in range(order) for i in range(j + 1)]
    rows, side = np.zeros((len(places), size + 3)), np.zeros(len(places))
    for row, (i, j) in enumerate(places):
        weight = 1.0 if i == j else np.sqrt(2.0)
        rows[row, at : at + 10] = -weight * unit[:, i, j]
        side[row] = -least if i == j else 0.0
    return rows, side
