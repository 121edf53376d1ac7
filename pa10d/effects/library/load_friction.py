"""Friction that grows with the transmitted torque."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, View
from pa10d.effects.rotor import ROTOR, link_load, rotor_starts


class LoadFriction(Effect):
    """The torque that passes through gear teeth and bearings presses them together, and what is
    pressed harder rubs more. mu is the share of the load that is lost to friction; the load is
    what the links ask for, without rotor and friction (rotor: the inertia that a rigid model
    cannot tell from the link, on axes that are fixed)."""

    id = "load_friction"
    title = "Load-dependent friction"
    equation = "τ = μ·|τ_load - rotor·q̈|·tanh(q̇/v0)"
    uses_model = True
    coefficients = (Coefficient("mu", "1", lower=0.0),)
    shapes = (ShapeParameter("v0", "rad/s", 1e-3, 0.3, "log", smoothing=True), ROTOR)
    signature = (
        "The level of friction (half the difference between going there and coming back) follows "
        "the torque that the gear passes on to the links."
    )
    confounders = {
        "coulomb": "while the load stays the same it is Coulomb friction",
        "position_friction": "the load of gravity depends on the angle as well",
        "thermal_friction": "a load that falls in the course of the run lowers friction, too",
    }
    experiment = "The same speed in several poses, or with several payloads."
    experiment_kind = "load_sweep"
    source = "Bittencourt & Gunnarsson, ASME J. Dyn. Sys. Meas. Control 134 (2012)"
    remedy = (
        "Every gear has it: keep it in the model. Where it has grown, inspect the gear's "
        "lubrication and teeth."
    )
    view = View("size of load", along=True)
    example = Example((0.12,), against="load", shape={"v0": 0.01})

    def columns(self, context, joints, shape):
        j = joints[0]
        load = link_load(context, j, shape.get("rotor", 0.0))
        return (np.abs(load) * context.sign(context.dq[:, j], shape["v0"]))[:, None]

    def starts(self, context, joints):
        return [
            {"v0": v0} | rotor
            for rotor in rotor_starts(context, joints[0], (0.05, 0.35, 0.7))
            for v0 in (0.01, 0.05)
        ]
