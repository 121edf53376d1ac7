"""A smooth map of one or two quantities: it takes an error away without naming its cause."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.effects.base import Array, Coefficient, Effect, Example, Shape, ShapeParameter, Value
from pa10d.effects.context import Context
from pa10d.effects.variables import parsed, unit_of, values_of

DEGREE = 3
SEGMENTS = {1: 24, 2: 8}  # of the range of each quantity, by how many there are
SLOW = 0.1  # of the range of a speed: below it, its segments are equally fine
# how strongly steps between neighbours, and coefficients themselves, are held beside bends: only
# where no data are does either matter
STEP, SIZE = 1e-3, 1e-5
SMOOTHING = "smoothing"
EXPLAINS_NOTHING = "removes the error, explains nothing: no physical effect"


class SmoothMap(Effect):
    """No physical effect, but a plain map of what a model lacks: the torque that is missing at
    each value of one or two quantities, drawn through the data as smoothly as they allow. It
    removes an error that no effect explains, and explains nothing itself. Outside the range that
    it was fitted on it stays what it is at the edge. smoothing is how stiff it is."""

    id = "smooth_map"
    title = "Smooth map"
    equation = "τ = Σ c·B(x)·B(y), cubic B-splines; smoothing·Σ(bends of c)² is held small"
    question = "chosen"
    signature = "A smooth curve or surface over the quantities, like nothing that the library has."
    experiment = "Move each of the quantities alone: what the map then shows may get a name."
    experiment_kind = "single_joint"
    source = (
        "Eilers & Marx, Flexible smoothing with B-splines and penalties, Statistical Science 11 "
        "(1996); stiffness by restricted maximum likelihood: Wood, Journal of the Royal "
        "Statistical Society B 73 (2011)"
    )
    remedy = "Look for the cause at the machine where the map is high; the map only hides it."

    def __init__(self, over: Sequence[str] = ("q2",)) -> None:
        """over: one or two names as in ``pa10d.effects.variables``, joints from 1."""
        self.over = tuple(over)
        self.uses_model = any(name.startswith("load") for name in self.over)
        count = SEGMENTS[len(self.over)] + DEGREE
        digits = [f"{i + 1:02d}" for i in range(count)]
        names = digits if len(self.over) == 1 else [f"{a}_{b}" for a in digits for b in digits]
        self.coefficients = tuple(Coefficient(f"c{name}", "N·m", nuisance=True) for name in names)
        ends = [(f"{name} {end}", unit_of(name)) for name in self.over for end in ("from", "to")]
        self.shapes = (
            *(ShapeParameter(name, unit, -np.inf, np.inf, "choice") for name, unit in ends),
            ShapeParameter(SMOOTHING, "1/(N·m)²", 0.0, np.inf, "choice"),
        )

    example = Example(
        tuple(3.0 * np.exp(-0.5 * ((i - 15.0) / 3.0) ** 2) for i in range(SEGMENTS[1] + DEGREE)),
        against="q",
        shape={"q2 from": -1.5, "q2 to": 1.5, SMOOTHING: 1.0},
    )

    def columns(self, context: Context, joints: Sequence[int], shape: Shape) -> Array:
        count = SEGMENTS[len(self.over)]
        parts = [
            splines(*placed(name, values_of(context, name), *self._ends(name, shape)), count)
            for name in self.over
        ]
        if len(parts) == 1:
            return parts[0]
        return np.asarray((parts[0][:, :, None] * parts[1][:, None, :]).reshape(len(context.t), -1))

    def penalty(self, shape: Shape) -> Array:
        """Rows R (r, k) in 1/(N·m): ‖R·c‖² is how far the coefficients bend, and, far more
        faintly, how far they differ from their neighbours and from nothing."""
        one = np.eye(SEGMENTS[len(self.over)] + DEGREE)
        rows = []
        for order, weight in ((2, 1.0), (1, STEP), (0, SIZE)):
            rough = np.sqrt(weight * shape[SMOOTHING]) * np.diff(one, order, axis=0)
            if len(self.over) == 1:
                rows.append(rough)
            else:
                rows += [np.kron(rough, one), np.kron(one, rough)]
        return np.concatenate(rows)

    def outside(self, context: Context, shape: Shape) -> NDArray[np.bool_]:
        """(N,): where a quantity is beyond the range that the map was fitted on."""
        beyond = np.zeros(len(context.t), dtype=bool)
        for name in self.over:
            low, high = self._ends(name, shape)
            values = values_of(context, name)
            beyond |= (values < low) | (values > high)
        return beyond

    def values(
        self, coefficients: Array, covariance: Array, shape: Shape, shape_errors: Shape
    ) -> dict[str, Value]:
        """Its lowest and its highest coefficient, which the surface never leaves, and the range
        that it was fitted on."""
        errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        low, high = int(np.argmin(coefficients)), int(np.argmax(coefficients))
        ends = {
            "lowest": Value(float(coefficients[low]), float(errors[low]), "N·m"),
            "highest": Value(float(coefficients[high]), float(errors[high]), "N·m"),
        }
        return ends | super().values(coefficients, covariance, shape, shape_errors)

    def starts(self, context: Context, joints: Sequence[int]) -> list[Shape]:
        """Over the whole motion of a run, moderately stiff."""
        ends = {name: values_of(context, name) for name in self.over}
        return [self.shape_over({k: (v.min(), v.max()) for k, v in ends.items()}, 1.0)]

    def shape_over(self, ranges: dict[str, tuple[float, float]], smoothing: float) -> Shape:
        """The shape of a map of these ranges (name -> from, to)."""
        starts = {f"{name} from": float(low) for name, (low, _) in ranges.items()}
        stops = {f"{name} to": float(high) for name, (_, high) in ranges.items()}
        return {**starts, **stops, SMOOTHING: smoothing}

    def _ends(self, name: str, shape: Shape) -> tuple[float, float]:
        return shape[f"{name} from"], shape[f"{name} to"]


@cache
def smooth_map(over: tuple[str, ...]) -> SmoothMap:
    """The map over these quantities."""
    return SmoothMap(over)


def placed(name: str, values: Array, low: float, high: float) -> tuple[Array, float, float]:
    """The same values and ends on the scale on which the segments are equal: speeds near zero are
    drawn apart, because friction turns round there."""
    if parsed(name)[0] != "dq":
        return values, low, high
    scale = SLOW * max(abs(low), abs(high), 1e-9)
    return (
        np.arcsinh(values / scale),
        float(np.arcsinh(low / scale)),
        float(np.arcsinh(high / scale)),
    )


def splines(values: Array, low: float, high: float, segments: int) -> Array:
    """Cubic B-splines on equal segments of [low, high], (N, segments + 3); they add up to one, and
    stay as they are at the edge beyond it."""
    width = max(high - low, 1e-9) / segments
    knots = low + width * np.arange(-DEGREE, segments + DEGREE + 1)
    inside = np.clip(values, knots[DEGREE], knots[-DEGREE - 1])
    return np.asarray(scipy.interpolate.BSpline.design_matrix(inside, knots, DEGREE).toarray())
