"""Torque per ampere falls at high current."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example


class TorqueSaturation(Effect):
    """At high current the motor's iron is saturated and each further ampere brings less torque.
    Where torque is worked out from current, it reads too high at the peaks: true = measured -
    c3·measured³."""

    id = "torque_saturation"
    title = "Torque saturation"
    plainly = "its largest torques are read too high"
    equation = "τ = c3·τ_measured³,  τ_measured = τ_model + c3·τ_measured³"
    sensing = True
    uses_model = True
    coefficients = (Coefficient("c3", "1/(N·m)²", lower=0.0),)
    signature = (
        "The error appears at the peaks of torque only, when the arm is held against gravity as "
        "well as in motion, and makes them look larger."
    )
    confounders = {"nonlinear_viscous": "high speed and high torque often come together"}
    experiment = "Hold a heavy load still: without speed there is no friction to blame."
    experiment_kind = "load_sweep"
    source = "Hendershot & Miller, Design of Brushless Permanent-Magnet Machines (2010)"
    remedy = "Correct the table from current to torque, or stay below the knee."
    example = Example((8e-6,), against="total", motion="wander")

    def columns(self, context, joints, shape):
        return measured(context.quiet_total[:, joints[0]], shape.get("at", 0.0))[:, None] ** 3

    def relinearised(self, coefficients, shape):
        # what is asked for swings about the answer, the wider the nearer the turning point is: a
        # third of the way comes home where it swings up to five times as far
        new, old = max(float(coefficients[0]), 0.0), shape.get("at")
        return {"at": new if old is None else old + (new - old) / 3.0}


def measured(true, c3):
    """x with x - c3·x³ = true, on the branch through zero, up to its turning point (N·m)."""
    if c3 <= 0.0:
        return true
    top = 2.0 / np.sqrt(3.0 * c3)
    return top * np.sin(np.arcsin(np.clip(3.0 * true / top, -1.0, 1.0)) / 3.0)
