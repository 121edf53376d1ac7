"""Standard parameters that a body can have: every link's pseudo-inertia positive definite.

The pseudo-inertia of a link is [[Σ, m·c], [m·cᵀ, m]] with Σ = ½·tr(I)·1 - I the second moments
about the joint's origin; it is positive definite exactly if some distribution of positive mass
has these parameters (Traversaro et al. 2016; Wensing, Kim, Slotine 2018). Least squares under
that condition is a convex cone programme, solved by Clarabel; a second one chooses, among all that
torque cannot tell apart, the parameters nearest to a prior, the URDF's. Rotors that base parameters
take in stand beside the bodies: what a rotor does no body need be able to do.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import clarabel
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pa10d.dynamics.base import BaseParameters
from pa10d.dynamics.pseudo_inertia import (
    definiteness,
    pseudo_basis,
    pseudo_inertia,
    scaled,
    scales,
    size,
)

__all__ = ["Feasible", "definiteness", "feasible_fit", "pseudo_inertia"]

Array = NDArray[np.float64]

PRIOR_WIDTHS = (30.0, 3.0, 0.3)  # of the first stage's prior, in sizes of a typical link: it only
# keeps the problem regular; the narrower ones where torque says next to nothing of a body, and the
# solver is still on its way along what is free when its steps are used up
AROUND_ITSELF = 2  # times; each leaves a hundredth of the pull
SLACK = 0.1  # of a standard error that the second stage may move any estimate
FINEST = 1e5  # ratio of torque to noise beyond which data count as that good and no better
MARGIN = 1e-6  # smallest eigenvalue, in link sizes: definite, not just semidefinite
REACH = 10.0  # sizes of a typical link by which bodies may differ that ``least`` speaks of

GOOD = ("Solved", "AlmostSolved")
_UPPER = [(i, j) for j in range(4) for i in range(j + 1)]  # the cone's order of a triangle


@dataclass(frozen=True)
class Feasible:
    """standard (n, 10) parameters with definite pseudo-inertias, rotors (r,) not negative, extra
    (k,) within their bounds.

    cost: ‖T·x - y‖² at the solution; least: below that no bodies within REACH of it can come;
    status: the solver's word for how it ended
    """

    standard: Array
    rotors: Array
    extra: Array
    cost: float
    least: float
    status: str

    @property
    def found(self) -> bool:
        """Whether the solver reached a solution."""
        return self.status in GOOD


def feasible_fit(
    triangle: Array,
    target: Array,
    base: BaseParameters,
    prior: Array,
    lower: Array,
    upper: Array,
    bodies: tuple[Array, Array] | None = None,
    rotors: Array | None = None,
) -> Feasible:
    """argmin ‖T·[M·h + R·r; c] - y‖² over feasible h, r ≥ 0 and lower ≤ c ≤ upper; where that
    leaves a choice, the h nearest to the prior.

    triangle (m, b+k), target (m,): weighted least-squares problem in base parameters and k more
    unknowns, in units of the noise's standard deviation; prior: (n, 10) standard parameters
    bodies: rows (·, 10n) and target (·,) of what is known of single ones, in the same units
    rotors: R (b, r), what one of each rotor adds to the base parameters; none where left out
    """
    share = np.zeros((len(base), 0)) if rotors is None else rotors
    count = share.shape[1]
    triangle = np.hstack([triangle, triangle[:, : len(base)] @ share])
    lower = np.append(lower, np.zeros(count))
    upper = np.append(upper, np.full(count, np.inf))
    quality = float(np.linalg.norm(target)) / np.sqrt(max(len(target), 1))
    coarser = min(1.0, FINEST / max(quality, 1e-300))
    problem = _Problem(triangle * coarser, target * coarser, base, prior, lower, upper)
    if bodies is not None:
        problem.know(bodies[0] * coarser, bodies[1] * coarser)
    first, least, status = problem.nearest_to_data()
    if status in GOOD:
        second, refined, _ = problem.nearest_to_prior(first)
        first = second if refined in GOOD else first
    standard, chosen = problem.split(first)
    left = triangle @ np.concatenate([base.of(standard), chosen]) - target
    extra, found = np.split(chosen, [len(chosen) - count])
    return Feasible(standard, found, extra, float(left @ left), least / coarser**2, status)


class _Problem:
    """The cone programmes of both stages, in unknowns scaled by link sizes."""

    def __init__(
        self,
        triangle: Array,
        target: Array,
        base: BaseParameters,
        prior: Array,
        lower: Array,
        upper: Array,
    ) -> None:
        self.prior, self.lower, self.upper = prior, lower, upper
        self.inertial = 10 * len(prior)
        whole = np.hstack([triangle[:, : len(base)] @ base.matrix(), triangle[:, len(base) :]])
        norms = np.linalg.norm(whole[:, self.inertial :], axis=0)
        sizes = [scales(link) for link in prior]
        self.scale = np.concatenate([*sizes, 1.0 / np.where(norms > 0, norms, 1.0)])
        self.data, self.target = whole * self.scale, target
        self.wanted = prior.reshape(-1) / self.scale[: self.inertial]
        self.size = self.data.shape[1]

    @property
    def rows(self) -> int:
        """How many equations there are."""
        return len(self.data)

    def know(self, rows: Array, target: Array) -> None:
        """Equations (r,) of the standard parameters beside those of the data."""
        wide = np.zeros((len(rows), self.size))
        wide[:, : self.inertial] = rows * self.scale[: self.inertial]
        self.data = np.vstack([self.data, wide])
        self.target = np.append(self.target, target)

    def split(self, x: Array) -> tuple[Array, Array]:
        """Standard parameters (n, 10) and further unknowns of a scaled solution."""
        found = x * self.scale
        further = np.clip(found[self.inertial :], self.lower, self.upper)
        return found[: self.inertial].reshape(-1, 10), further

    def nearest_to_data(self) -> tuple[Array, float, str]:
        """Least squares, and what no others leave less than. A narrow prior would pull; so it is
        laid around what it led to, twice."""
        for width in PRIOR_WIDTHS:
            found, least, status = self._near(self.wanted, width)
            if status in GOOD:
                break
        narrow = status in GOOD and width < PRIOR_WIDTHS[0]
        for _ in range(AROUND_ITSELF if narrow else 0):
            again, less, refined = self._near(found[: self.inertial], width)
            found, least = (again, less) if refined in GOOD else (found, least)
        return found, least, status

    def _near(self, centre: Array, width: float) -> tuple[Array, float, str]:
        """With a prior of that width; the residual is an unknown of its own, so that nothing is
        squared.

        The cost f and the prior p together are least at x, to within the solver's gap. f is convex,
        so f(z) ≥ f(x) + ∇p(x)·(x - z) for all feasible z, and |x - z| is at most REACH per unknown.
        """
        unit = max(1.0, float(np.linalg.norm(self.target)) / np.sqrt(self.rows))
        weight = np.zeros(self.size)
        weight[: self.inertial] = 1.0 / (width * unit) ** 2
        linear = np.zeros(self.size + self.rows)
        linear[: self.inertial] = -weight[: self.inertial] * centre
        quadratic = np.concatenate([weight, np.ones(self.rows)])
        equal = np.hstack([self.data / unit, -np.identity(self.rows)])
        found, status, gap = self._solve(
            quadratic, linear, equal, self.target / unit, clarabel.ZeroConeT(self.rows)
        )
        cost = float(np.sum((self.data @ found - self.target) ** 2))
        pull = float(np.linalg.norm(found[: self.inertial] - centre)) / width**2
        doubt = pull * REACH * np.sqrt(self.inertial) + unit**2 * gap
        return found, max(cost - 2.0 * doubt, 0.0), status

    def nearest_to_prior(self, start: Array) -> tuple[Array, str, float]:
        """Move within what the data cannot tell: ‖T·(x - start)‖ stays below SLACK."""
        weight = np.zeros(self.size)
        weight[: self.inertial] = 1.0
        linear = np.zeros(self.size)
        linear[: self.inertial] = -self.wanted
        ball = np.vstack([np.zeros(self.size), -self.data / SLACK])
        side = np.concatenate([[1.0], -self.data @ start / SLACK])
        cone = clarabel.SecondOrderConeT(self.rows + 1)
        return self._solve(weight, linear, ball, side, cone)

    def _solve(
        self, quadratic: Array, linear: Array, matrix: Array, side: Array, cone: Any
    ) -> tuple[Array, str, float]:
        """argmin ½xᵀQx + lᵀx with side - matrix·x in the cone and all that makes x feasible; how it
        ended, and what the least may lie below."""
        width = len(linear)
        blocks, sides, cones = [matrix], [side], [cone]
        friction = self.scale[self.inertial :]
        bounds, limits = _bounds(self.lower, self.upper, friction, self.inertial, width)
        if len(limits):
            blocks.append(bounds)
            sides.append(limits)
            cones.append(clarabel.NonnegativeConeT(len(limits)))
        for link, values in enumerate(self.prior):
            definite, limit = _definite(values, self.scale[10 * link : 10 * link + 10])
            own = np.zeros((10, width))
            own[:, 10 * link : 10 * link + 10] = definite
            blocks.append(own)
            sides.append(limit)
            cones.append(clarabel.PSDTriangleConeT(4))
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        solver = clarabel.DefaultSolver(
            sp.diags(quadratic, format="csc"),
            linear,
            sp.csc_matrix(np.vstack(blocks)),
            np.concatenate(sides),
            cones,
            settings,
        )
        answer = solver.solve()
        gap = abs(answer.obj_val - answer.obj_val_dual)
        return np.asarray(answer.x)[: self.size], str(answer.status), float(gap)


def _definite(link: Array, scale: Array) -> tuple[Array, Array]:
    """A, b of -A·x + b in the cone of positive semidefinite matrices, for scaled parameters."""
    mass, length = size(link)
    unit = scaled(pseudo_basis() * scale[:, None, None] / mass, np.full(10, length))
    matrix, side = np.empty((10, 10)), np.empty(10)
    for row, (i, j) in enumerate(_UPPER):
        weight = 1.0 if i == j else np.sqrt(2.0)
        matrix[row] = -weight * unit[:, i, j]
        side[row] = -MARGIN if i == j else 0.0
    return matrix, side


def _bounds(lower: Array, upper: Array, scale: Array, first: int, size: int) -> tuple[Array, Array]:
    low, high = np.flatnonzero(np.isfinite(lower)), np.flatnonzero(np.isfinite(upper))
    count = len(low) + len(high)
    signs = np.concatenate([-np.ones(len(low)), np.ones(len(high))])
    columns = first + np.concatenate([low, high]).astype(int)
    matrix = np.zeros((count, size))
    matrix[np.arange(count), columns] = signs
    return matrix, np.concatenate([-lower[low] / scale[low], upper[high] / scale[high]])
