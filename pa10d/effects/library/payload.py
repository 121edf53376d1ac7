"""A rigid body added to the last link."""

import numpy as np

from pa10d.dynamics import regressor
from pa10d.dynamics.base import random_motion
from pa10d.dynamics.robot import PARAMETER_NAMES
from pa10d.effects.base import Coefficient, Effect, Example, Value, View, fitted

UNFELT = 1e-6  # of what the arm feels most of a payload's moments: rounded axes


class Payload(Effect):
    """The arm carries something that the model was not told of. mass is how heavy it is, cx, cy
    and cz where its centre of mass lies, in the frame of the last joint."""

    id = "payload"
    title = "Payload"
    noun = "a payload"
    equation = "τ = Y_last(q, q̇, q̈)·[m, m·cx, m·cy, m·cz, Ixx … Izz]"
    scope = "robot"
    question = "changed"
    reaches_other_joints = True
    picked_up = True
    derived = {"cx": ("mass",), "cy": ("mass",), "cz": ("mass",)}
    coefficients = (
        Coefficient("mass", "kg", lower=0.0),
        Coefficient("mx", "kg·m"),
        Coefficient("my", "kg·m"),
        Coefficient("mz", "kg·m"),
        *(Coefficient(name, "kg·m²", nuisance=True) for name in PARAMETER_NAMES[4:]),
    )
    signature = (
        "All joints that carry the tool are off together, as if the last link had become heavier."
    )
    confounders = {
        "rotor_inertia": "another rotor resists being sped up, too, but it weighs nothing and "
        "moves no other joint's torque",
        "base_tilt": "both change gravity in several joints",
        "torque_gain": "on one joint a heavier load and a weaker motor look alike",
    }
    experiment = (
        "Move the wrist while the arm stays: a tilt or a gain does not care how the wrist is "
        "turned, a payload does."
    )
    experiment_kind = "excitation"
    source = (
        "Khalil, Gautier & Lemoine, Identification of the payload inertial parameters of "
        "industrial manipulators, ICRA (2007)"
    )
    remedy = "Look at what the arm is holding; enter it as the profile's tool, or take it off."
    view = View()
    example = Example(
        (5.0, 0.0, 0.15, 0.6, *(0.0,) * 6), against="load", motion="wander", joints=(2,)
    )

    def columns(self, context, joints, shape):
        last = 10 * (context.robot.n - 1)
        return regressor(
            context.robot, context.q, context.dq, context.ddq, np.arange(last, last + 10)
        )

    def never_shown(self, robot, joints):
        last = 10 * (robot.n - 1)
        moments = regressor(robot, *random_motion(robot, 30, 1), np.arange(last + 1, last + 4))
        felt = np.abs(moments).max(axis=(0, 1))
        return frozenset(
            f"c{axis}" for axis, x in zip("xyz", felt, strict=True) if x < UNFELT * felt.max()
        )

    def values(self, coefficients, covariance, shape, shape_errors):
        m, *moments = coefficients[:4]
        out = {"mass": Value(float(m), float(np.sqrt(max(covariance[0, 0], 0.0))), "kg")}
        safe = m if abs(m) > 1e-9 else 1e-9
        for i, axis in enumerate("xyz"):
            gradient = np.zeros(len(coefficients))
            gradient[0], gradient[i + 1] = -moments[i] / safe**2, 1.0 / safe
            error = np.sqrt(max(gradient @ covariance @ gradient, 0.0))
            out[f"c{axis}"] = fitted(float(moments[i] / safe), float(error), "m")
        return out
