"""A reading that is nothing up to some torque, and less by that beyond it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.effects.base import Array, Coefficient, Effect, Example, Shape, ShapeParameter
from pa10d.effects.context import Context


class DeadBand(Effect):
    """No effect of an arm, but of how its torque is measured: an amplifier, a threshold or a seal
    between sensor and load swallows the first few newton metres, and all that is read lies nearer
    to zero by that. What rubs is missing from it, and gravity has a step where it changes sides.
    Whatever effect of an arm bends near there imitates a part of it."""

    id = "dead_band"
    title = "Dead band of a reading"
    equation = "τ_read = τ + share·max(-d, min(d, τ)), share = -1"
    question = "chosen"
    sensing = True
    uses_model = True
    coefficients = (Coefficient("share", "1", lower=-np.inf, upper=0.0),)
    shapes = (ShapeParameter("d", "N·m", 1e-6, 1e6, "log"),)
    signature = "The reading stays at zero while the arm needs some torque, either way."
    experiment = "Lay small weights on a joint at rest, one after the other."
    experiment_kind = "load_sweep"
    source = "Åström & Wittenmark, Adaptive Control (1995), section 10.4"
    remedy = "Look at how the torque is measured: what swallows small values."
    example = Example((-1.0,), against="total", shape={"d": 4.0}, motion="wander")

    def columns(self, context: Context, joints: Sequence[int], shape: Shape) -> Array:
        torque = context.quiet_total[:, joints[0]]
        return np.clip(torque, -shape["d"], shape["d"])[:, None]

    def starts(self, context: Context, joints: Sequence[int]) -> list[Shape]:
        size = float(np.std(context.quiet_total[:, joints[0]]))
        return [{"d": size * float(part)} for part in 2.0 ** np.arange(-5.0, 1.0)]
