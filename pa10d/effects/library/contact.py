"""One-sided contact within the range of motion."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter

LEAST_FREE = 0.05  # of the joint's range


class Contact(Effect):
    """Beyond one angle something pushes back: a stop, an obstacle, a cable at its end. It begins
    at qs and grows with stiffness k; side is 1 where it acts above qs and -1 where below."""

    id = "contact"
    title = "Contact"
    noun = "a contact beyond one angle"
    equation = "τ = k·side·max(0, side·(q - qs))"
    follows_angle = True
    coefficients = (Coefficient("k", "N·m/rad", lower=0.0),)
    shapes = (
        ShapeParameter("qs", "rad", -10.0, 10.0, "linear", step=0.08),
        ShapeParameter(
            "side",
            "1",
            -1.0,
            1.0,
            "choice",
            says={1.0: "above qs", -1.0: "below qs"},
        ),
    )
    repeatable = True
    otherwise = "spring"
    also_changes = True
    signature = (
        "There is no error up to one angle; beyond it, on one side, it grows, at any speed and in "
        "both directions of motion alike."
    )
    confounders = {
        "spring": "both push back with the angle; a spring does so over the whole range",
        "position_friction": "both begin at an angle; friction changes its sign with the "
        "direction of motion",
    }
    experiment = "Approach the angle slowly from both sides."
    experiment_kind = "point_to_point"
    source = "Hunt & Crossley, ASME J. Applied Mechanics 42 (1975), linear limit"
    remedy = "Look for what the arm touches there; free the cable, move the obstacle or the stop."
    example = Example((60.0,), against="q", shape={"qs": 0.85, "side": 1.0})

    def columns(self, context, joints, shape):
        side = shape["side"]
        depth = np.maximum(0.0, side * (context.q[:, joints[0]] - shape["qs"]))
        return (side * depth)[:, None]

    def is_itself(self, shape, low, high):
        free = shape["qs"] - low if shape["side"] > 0 else high - shape["qs"]
        return free > LEAST_FREE * (high - low)  # touched everywhere it is a spring

    def starts(self, context, joints):
        low, high = np.min(context.q[:, joints[0]]), np.max(context.q[:, joints[0]])
        span = high - low
        shares = (
            0.03,
            0.07,
            0.12,
            0.2,
            0.3,
            0.4,
            0.55,
            0.7,
            0.85,
        )  # a cable slack for a little way
        return [{"qs": float(high - s * span), "side": 1.0} for s in shares] + [
            {"qs": float(low + s * span), "side": -1.0} for s in shares
        ]
