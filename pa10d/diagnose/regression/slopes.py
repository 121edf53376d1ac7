"""How a term's torque moves with its shape, and where a shape near its best one should go."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import SLOPE_STEP
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.partial import normal_equations, solve_symmetric
from pa10d.diagnose.regression.shapes import free_shapes
from pa10d.diagnose.regression.side import Side
from pa10d.model import Term
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]


def with_slopes(side: Side, term: Term) -> PerJoint:
    """joint -> (m_j, k + s): the term's k columns, and by central differences how its torque
    moves with each of its s free shapes, N·m per unit."""
    shapes, widths = [term.shape], []
    for s in free_shapes(term.effect, term.shape):
        value = term.shape[s.name]
        own = abs(value) if s.scale == "log" else max(abs(value), s.step_at(term.shape))
        step = SLOPE_STEP * (own or 1e-3 * (s.upper - s.lower))
        ends = [value - step, value + step]
        if s.lower <= value <= s.upper:  # else an angle of a joint that turns on and on
            ends = [float(np.clip(end, s.lower, s.upper)) for end in ends]
        shapes += [{**term.shape, s.name: end} for end in ends]
        widths.append(ends[1] - ends[0])
    out = {}
    for j, c in side.columns(term.effect, term.joints, shapes).items():
        each = c.reshape(len(c), len(shapes), c.shape[1] // len(shapes))
        torque = each[:, 1:] @ term.coefficients
        slopes = (torque[:, 1::2] - torque[:, ::2]) / np.array(widths)
        out[j] = np.column_stack([each[:, 0], slopes])
    return out


def newton_move(side: Side, rest: LeastSquares, term: Term) -> Array:
    """(s,) by how much each free shape would have to change if the torque were linear in it
    (Gauss-Newton); the term's coefficients and all that ``rest`` has move along."""
    gram, rhs = normal_equations(rest, with_slopes(side, term))
    return solve_symmetric(gram, rhs)[len(term.coefficients) :]
