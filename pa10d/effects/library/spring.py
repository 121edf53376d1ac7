"""A spring across the joint."""

import numpy as np

from pa10d.dynamics import inverse_dynamics
from pa10d.dynamics.base import random_motion
from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, Value

ALIKE = 1e-6  # of the largest of a joint's weights: rounded axes
NONE = 1e-9  # N: rounded, too


class Spring(Effect):
    """Something pulls the joint back to the angle q0: hoses and cables along the arm (the dress
    pack), or a counterbalance. On a slide that carries its weight the constant part of the pull is
    the weight's, too (constant 0): q0 is left open.
    """

    id = "spring"
    title = "Spring"
    noun = "a spring"
    equation = "τ = k·(q - q0)"
    follows_angle = True
    coefficients = (Coefficient("k", "N·m/rad"), Coefficient("kq0", "N·m"))
    shapes = (ShapeParameter("constant", "1", 0.0, 1.0, "choice", optional=True),)
    also_changes = True
    below_zero = (
        "It pushes away from q0, as hoses do not: a counterbalance beyond its middle does, and so "
        "does gravity where an angle, an axis or a length is not as the URDF says"
    )
    derived = {"q0": ("k",)}
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
        return np.column_stack([q, np.full_like(q, -shape.get("constant", 1.0))])

    def starts(self, context, joints):
        slides = context.robot.prismatic[joints[0]]
        return [{}, {"constant": 0.0}] if slides else [{}]

    def never_shown(self, robot, joints):
        """q0 of a slide that bears a weight, the same wherever the arm stands."""
        q = random_motion(robot, 30, 1)[0]
        rest = np.zeros_like(q)
        weight = inverse_dynamics(robot, robot.parameters, q, rest, rest)[:, joints[0]]
        most = np.abs(weight).max()
        same = most > NONE and np.ptp(weight) <= ALIKE * most
        return frozenset({"q0"} if robot.prismatic[joints[0]] and same else ())

    def values(self, coefficients, covariance, shape, shape_errors):
        if not shape.get("constant", 1.0):
            error = float(np.sqrt(max(covariance[0, 0], 0.0)))
            return {
                "k": Value(float(coefficients[0]), error, "N·m/rad"),
                "q0": Value(0.0, 0.0, "rad", determined=False),
            }
        k, kq0 = (float(c) for c in coefficients)
        safe = k if abs(k) > 1e-9 else 1e-9
        gradient = np.array([-kq0 / safe**2, 1.0 / safe])
        errors = np.sqrt(np.maximum([covariance[0, 0], gradient @ covariance @ gradient], 0.0))
        return {
            "k": Value(k, float(errors[0]), "N·m/rad"),
            "q0": Value(kq0 / safe, float(errors[1]), "rad"),
        }
