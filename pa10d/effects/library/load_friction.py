"""Friction that grows with the transmitted torque."""

from dataclasses import replace

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, Value, View
from pa10d.effects.rotor import ROTOR, quiet_link_load, rotor_starts


class LoadFriction(Effect):
    """The torque that passes through gear teeth and bearings presses them together, and what is
    pressed harder rubs more. mu is the share of the load that is lost to friction; the load is
    what the links ask for, without rotor and friction (rotor: the inertia that a rigid model
    cannot tell from the link, on axes that are fixed). Where it is directional, the share is
    larger while the motor drives the load than while the load drives the motor; uneven is dmu/mu.
    """

    id = "load_friction"
    title = "Load-dependent friction"
    equation = "τ = μ·|τ_load - rotor·q̈|·tanh(q̇/v0),  μ = mu + dmu·sign(τ_load·q̇)"
    uses_model = True
    carried = True
    reads_as_load = True
    derived = {"uneven": ("mu",), "dmu": ("mu", "uneven")}
    coefficients = (Coefficient("mu", "1", lower=0.0),)
    shapes = (
        ShapeParameter("v0", "rad/s", 1e-3, 0.3, "log", smoothing=True),
        ROTOR,
        ShapeParameter(
            "directional",
            "1",
            0.0,
            1.0,
            "choice",
            optional=True,
            says={0.0: "alike whoever drives", 1.0: "more while the motor drives the load"},
        ),
        ShapeParameter("uneven", "1", 0.0, 1.0, optional=True),
    )
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
        load = quiet_link_load(context, j, shape.get("rotor", 0.0))
        rubs = context.friction(j, self.level(context, joints, shape), shape["v0"])
        sign = context.sign(context.dq[:, j], shape["v0"])
        return (rubs + shape.get("uneven", 0.0) * load * sign**2)[:, None]

    def level(self, context, joints, shape):
        return np.abs(quiet_link_load(context, joints[0], shape.get("rotor", 0.0)))

    def starts(self, context, joints):
        alike = [
            {"v0": v0} | rotor
            for rotor in rotor_starts(context, joints[0], (0.05, 0.35, 0.7))
            for v0 in (0.01, 0.05)
        ]
        return alike + [s | {"directional": 1.0, "uneven": 0.0} for s in alike]

    def values(self, coefficients, covariance, shape, shape_errors):
        """A share that differs between the two directions of the power is, to the last sample, a
        torque that reads larger by that much; and one that all gears have the bodies take in, and
        with it as much of each mu. So both are known as well as a torque constant is."""
        out = super().values(coefficients, covariance, shape, shape_errors)
        mu = out["mu"]
        out["mu"] = replace(mu, by_gain=mu.value)
        if "uneven" in out:
            uneven, own = out["uneven"], mu.value
            error = float(np.hypot(own * uneven.std_error, uneven.value * mu.std_error))
            known = uneven.determined
            out["uneven"] = replace(uneven, by_gain=1.0 / own if own > 0.0 else 0.0)
            out["dmu"] = Value(own * uneven.value, error, "1", determined=known, by_gain=1.0)
        return out
