"""Friction that falls as the joint warms."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, smooth_sign

COLD = 20.0  # °C, from which measured warmth counts; the same in every run
KELVIN = 10.0  # K of warmth to which the coefficients refer where temperature is measured


class ThermalFriction(Effect):
    """Grease thins as the joint warms, so friction falls during the first minutes of motion. dFv
    and dFc are what a joint that is warm through has lost. Without a temperature reading a run
    starts cold and warms with the time constant T; with one, the loss follows the temperature
    (dFv and dFc per 10 K above 20 °C) and T plays no part."""

    id = "thermal_friction"
    title = "Warm-up of friction"
    noun = "friction that changes as it warms up"
    equation = "τ = -w·(dFv·q̇ + dFc·sign(q̇)),  w = 1 - exp(-t/T), or w = (temperature - 20 °C)/10 K"
    coefficients = (
        Coefficient("dFv", "N·m·s/rad", lower=0.0),
        Coefficient("dFc", "N·m", lower=0.0),
    )
    shapes = (ShapeParameter("T", "s", 2.0, 2000.0, "log"),)
    signature = (
        "In the same pose at the same speed, friction is lower late in the run than at its start."
    )
    confounders = {
        "load_friction": "a load that falls in the course of the run lowers friction, too",
        "viscous": "its mean over a run is viscous friction",
    }
    experiment = "Repeat the first minute at the end of a long run."
    experiment_kind = "warm_up"
    source = "Bittencourt & Gunnarsson, ASME J. Dyn. Sys. Meas. Control 134 (2012)"
    remedy = "Warm the joint up before identification, and before work that needs the model."
    example = Example((6.0, 2.0), against="dq", shape={"T": 150.0}, motion="warm_up")

    def columns(self, context, joints, shape):
        j = joints[0]
        warm = measured_warmth(context, j)
        if warm is None:
            warm = 1.0 - np.exp(-context.t / shape["T"])
        v = context.dq[:, j]
        return -np.column_stack([warm * v, warm * smooth_sign(v, context.softness(0.01))])

    def starts(self, context, joints):
        span = float(context.t[-1] - context.t[0])
        shares = (0.1, 0.25, 0.6, 1.5) if measured_warmth(context, joints[0]) is None else (1.0,)
        return [{"T": float(np.clip(span * s, 2.0, 2000.0))} for s in shares]


def measured_warmth(context, joint):
    """(N,) warmth in units of KELVIN above COLD; None where this joint has no thermometer."""
    if context.temperature is None or not np.isfinite(context.temperature[:, joint]).all():
        return None
    return (context.temperature[:, joint] - COLD) / KELVIN
