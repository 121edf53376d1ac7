"""Friction tied to a place of the joint."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, smooth_sign


class PositionFriction(Effect):
    """A place where the joint runs harder, or easier, than elsewhere: a worn spot, a tight seal,
    a bearing that pinches. A is the friction added at its centre qc (negative: missing there), w
    how far it reaches."""

    id = "position_friction"
    title = "Position-dependent friction"
    equation = "τ = A·exp(-(q - qc)²/(2·w²))·sign(q̇)"
    coefficients = (Coefficient("A", "N·m"),)
    shapes = (
        ShapeParameter("qc", "rad", -10.0, 10.0, "linear"),
        ShapeParameter("w", "rad", 0.02, 1.5, "log"),
    )
    signature = (
        "In one range of the joint's angle friction is higher (or lower), and it opposes the "
        "motion in both directions."
    )
    confounders = {
        "torque_ripple": "both are tied to the angle; ripple does not change its sign with the "
        "direction of motion",
        "contact": "both begin at an angle; a stop pushes one way only, whatever the direction",
        "load_friction": "the load of gravity depends on the angle as well",
    }
    experiment = "Cross the range at several speeds, in both directions."
    experiment_kind = "velocity_sweep"
    source = "Armstrong-Hélouvry, Control of Machines with Friction (1991), ch. 4"
    remedy = "Inspect bearing, seal and gear teeth at that angle for dirt and wear."
    example = Example((5.0,), against="q", shape={"qc": 0.7, "w": 0.08})

    def columns(self, context, joints, shape):
        j = joints[0]
        bump = np.exp(-0.5 * ((context.q[:, j] - shape["qc"]) / shape["w"]) ** 2)
        return (bump * smooth_sign(context.dq[:, j], context.softness(0.01)))[:, None]

    def starts(self, context, joints):
        low, high = np.quantile(context.q[:, joints[0]], [0.03, 0.97])
        span = max(high - low, 1e-3)
        return [
            {"qc": float(low + span * place), "w": float(np.clip(span * width, 0.02, 1.5))}
            for width, places in ((0.05, np.linspace(0, 1, 12)), (0.15, np.linspace(0, 1, 6)))
            for place in places
        ]
