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
from pa10d.regression.problem import Knowledge

Array = NDArray[np.float64]

WIDEST = 1000.0  # % of a link's own figures; beyond that nobody knows anything


@dataclass(frozen=True)
class Prior(Knowledge):
    """std_errors (b,): of the base parameters before any data, endless where nothing is known;
    percent: of what is usual for a link, as it was asked."""

    std_errors: Array
    percent: float

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
