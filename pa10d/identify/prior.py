"""How near the bodies are to the URDF's, where somebody knows: it decides what the data leave open.

Every parameter of a link (mass, first moments, inertias) is taken as the URDF's, give or take a
share of what is usual for a link of its mass and size, independently of all others. What the base
parameters have of that is a row for each of them in the weighted least squares, and counts in
their standard errors. Where rotors are one with their links nothing is known beforehand: a URDF
has no rotors. Friction and all effects stay free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics.pseudo_inertia import scales
from pa10d.regression.layout import Layout, rotors_within
from pa10d.regression.triangle import Triangle

Array = NDArray[np.float64]

WIDEST = 1000.0  # % of a link's own figures; beyond that nobody knows anything


@dataclass(frozen=True)
class Prior:
    """rows (b, b), target (b,): ‖rows·h - target‖² is added to the squares of the weighted fit;
    std_errors (b,): of the base parameters before any data, endless where nothing is known."""

    rows: Array
    target: Array
    std_errors: Array
    percent: float

    @property
    def triangle(self) -> Triangle:
        """Beside those of the joints; its unknowns are the base parameters, its weight is 1."""
        made = Triangle(len(self.target) + 1)
        made.add(np.column_stack([self.rows, self.target]))
        return made

    def unknowns(self) -> NDArray[np.int64]:
        """Which of all unknowns they are."""
        return np.arange(len(self.target))

    def information(self, size: int) -> Array:
        """(size, size): what it adds to the normal matrix of all unknowns."""
        out = np.zeros((size, size))
        b = len(self.target)
        out[:b, :b] = self.rows.T @ self.rows
        return out

    def document(self) -> dict[str, object]:
        """Kept with the model."""
        known = [float(s) if np.isfinite(s) else None for s in self.std_errors]
        return {"percent": self.percent, "std_errors": known}


def urdf_prior(layout: Layout, percent: float) -> Prior:
    """The URDF's bodies within ``percent`` (one standard deviation) of what is usual for a link."""
    if not 0 < percent <= WIDEST:
        raise UserError(f"prior: found {percent:g} %, expected more than 0 and at most {WIDEST:g}")
    robot, base = layout.robot, layout.base
    size = 0.01 * percent * np.concatenate([scales(link) for link in robot.parameters])
    spread = base.matrix() * size
    covariance = spread @ spread.T
    rows = scipy.linalg.solve_triangular(
        np.linalg.cholesky(covariance), np.eye(len(base)), lower=True
    )
    std_errors = np.sqrt(np.diag(covariance))
    rotors = rotors_within(robot, base)
    if rotors.size:
        std_errors = np.where(np.any(np.abs(rotors) > 1e-6, axis=1), np.inf, std_errors)
        free = np.linalg.qr(rows @ rotors)[0]
        rows = rows - free @ (free.T @ rows)
    return Prior(rows, rows @ base.of(robot.parameters), std_errors, percent)
