"""A spring across the joint."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, Value


class Spring(Effect):
    """Something pulls the joint back to the angle q0: hoses and cables along the arm (the dress
    pack), or a counterbalance."""

    id = "spring"
    title = "Spring"
    noun = "a spring"
    equation = "τ = k·(q - q0)"
    follows_angle = True
    coefficients = (Coefficient("k", "N·m/rad"), Coefficient("kq0", "N·m"))
    also_changes = True
    signature = (
        "Against the joint's angle the error is a straight line, at any speed and whatever the "
        "other joints do."
    )
    confounders = {
        "torque_offset": "over a short range of angles a spring pulls almost constantly",
        "encoder_offset": "a shifted angle leaves an error that leans with the angle as well",
        "contact": "both push back with the angle; a spring does so over the whole range",
    }
    experiment = "The same motion with the other joints elsewhere: gravity changes, a spring stays."
    experiment_kind = "single_joint"
    source = "Khalil & Dombre, Modeling, Identification and Control of Robots (2002), ch. 9"
    remedy = "Look at hoses and cables along the arm; adjust the counterbalance."
    example = Example((15.0, 7.5), against="q")

    def columns(self, context, joints, shape):
        q = context.q[:, joints[0]]
        return np.column_stack([q, -np.ones_like(q)])

    def values(self, coefficients, covariance, shape, shape_errors):
        k, kq0 = (float(c) for c in coefficients)
        safe = k if abs(k) > 1e-9 else 1e-9
        gradient = np.array([-kq0 / safe**2, 1.0 / safe])
        errors = np.sqrt(np.maximum([covariance[0, 0], gradient @ covariance @ gradient], 0.0))
        return {
            "k": Value(k, float(errors[0]), "N·m/rad"),
            "q0": Value(kq0 / safe, float(errors[1]), "rad"),
        }
