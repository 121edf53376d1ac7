"""Viscous friction that is not proportional to speed."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter


class NonlinearViscous(Effect):
    """Lubricant that is churned rather than sheared: resistance grows faster than speed, twice
    the speed costs more than twice the torque."""

    id = "nonlinear_viscous"
    title = "Nonlinear viscous friction"
    plainly = "friction that grows faster than the speed"
    equation = "τ = Fp·|q̇|^p·sign(q̇), p > 1"
    coefficients = (Coefficient("Fp", "N·m·(s/rad)^p", lower=0.0),)
    shapes = (ShapeParameter("p", "1", 1.2, 3.5, "log", step=0.2),)
    signature = (
        "Against speed the error is a curve that bends away at high speed, upwards in one "
        "direction and downwards in the other."
    )
    confounders = {
        "viscous": "over a narrow range of speeds the curve is a line",
        "torque_saturation": "high speed and high torque often come together",
        "stribeck": "a wide bump at low speed bends the same curve from its other end",
    }
    experiment = (
        "High constant speeds under several loads: friction follows the speed, saturation the "
        "torque."
    )
    experiment_kind = "velocity_sweep"
    source = "Bittencourt & Gunnarsson, ASME J. Dyn. Sys. Meas. Control 134 (2012)"
    remedy = "Check amount and grade of the lubricant; warm the joint up before fast work."
    example = Example((9.0,), against="dq", shape={"p": 2.2})

    def columns(self, context, joints, shape):
        v = context.dq[:, joints[0]]
        return (np.abs(v) ** shape["p"] * np.sign(v))[:, None]

    def starts(self, context, joints):
        return [{"p": p} for p in (1.4, 2.0, 3.0)]
