"""Friction that falls as the joint warms."""

from dataclasses import replace

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, View
from pa10d.effects.memory import fading

COLD = 20.0  # °C, from which measured warmth counts; the same in every run
KELVIN = 10.0  # K of warmth to which the coefficients refer where temperature is measured


class ThermalFriction(Effect):
    """Grease thins as the joint warms, so friction falls during the first minutes of motion. A run
    starts cold and warms with the time constant T: by what surrounds the joint, whatever it does
    (heated 0; dFv and dFc are what a joint that is warm through has lost), or by its own friction
    (heated 1; dFv and dFc are lost per watt of it, and rest lets the joint cool). With a
    temperature reading the loss follows that (dFv and dFc per 10 K above 20 °C), and T plays no
    part."""

    id = "thermal_friction"
    title = "Warm-up of friction"
    noun = "friction that changes as it warms up"
    equation = (
        "τ = -w·(dFv·q̇ + dFc·sign(q̇)),  T·ẇ = 1 - w, or T·ẇ = |τ_friction·q̇|/1 W - w, "
        "or w = (temperature - 20 °C)/10 K"
    )
    uses_model = True
    feels_own_heat = True
    escapes_demo = "the arm warms up in its first minute and stays warm"
    coefficients = (
        Coefficient("dFv", "N·m·s/rad", lower=0.0),
        Coefficient("dFc", "N·m", lower=0.0),
    )
    shapes = (
        ShapeParameter("T", "s", 2.0, 2000.0, "log"),
        ShapeParameter(
            "heated",
            "1",
            0.0,
            1.0,
            "choice",
            says={
                0.0: "warms with time, whatever the joint does",
                1.0: "warms by its own friction",
            },
        ),
    )
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
    remembers = "how warm the joint is (apart: cold, unless its temperature is known)"
    view = View("t", along=True)
    example = Example((6.0, 2.0), against="dq", shape={"T": 150.0, "heated": 0.0}, motion="warm_up")

    def columns(self, context, joints, shape):
        j = joints[0]
        warm = measured_warmth(context, j)
        if warm is None and context.apart:
            warm = np.zeros(len(context.q))
        elif warm is None and shape["heated"]:
            warm = own_warmth(context, j, shape["T"])
        elif warm is None:
            warm = 1.0 - np.exp(-context.t / shape["T"])
        dry = context.friction(j, warm, context.softness(context.corner(j)))
        return -np.column_stack([warm * context.dq[:, j], dry])

    def starts(self, context, joints):
        span = float(context.t[-1] - context.t[0])
        known = measured_warmth(context, joints[0]) is not None
        return [
            {"T": float(np.clip(span * share, 2.0, 2000.0)), "heated": heated}
            for share in ((1.0,) if known else (0.1, 0.25, 0.6, 1.5))
            for heated in ((0.0,) if known else (0.0, 1.0))
        ]

    def values(self, coefficients, covariance, shape, shape_errors):
        out = super().values(coefficients, covariance, shape, shape_errors)
        if shape.get("heated") == 1.0:
            for name in ("dFv", "dFc"):
                out[name] = replace(out[name], unit=f"{out[name].unit}/W")
        elif shape_errors.get("T") == 0.0:  # a measured temperature: T plays no part
            for name in ("dFv", "dFc"):
                out[name] = replace(out[name], unit=f"{out[name].unit} per 10 K")
            del out["T"], out["heated"]
        return out


def own_warmth(context, joint, time_constant):
    """(N,) solution of T·ẇ = heat - w from cold, heat in W and constant over each interval."""
    heat = context.friction_heat[:, joint]
    mean = 0.5 * (heat[1:] + heat[:-1])
    kept = float(np.exp(-context.dt / time_constant))
    return np.concatenate([np.zeros(1), (1.0 - kept) * fading(mean, kept)])


def measured_warmth(context, joint):
    """(N,) warmth in units of KELVIN above COLD; None where this joint has no thermometer."""
    if context.temperature is None or not np.isfinite(context.temperature[:, joint]).all():
        return None
    return (context.temperature[:, joint] - COLD) / KELVIN
