"""Torque that repeats with the angle."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, Value, View

USUAL = (25.0, 50.0, 80.0, 100.0, 120.0, 160.0, 200.0)  # ratios of harmonic drives, and twice them


class TorqueRipple(Effect):
    """A torque that repeats with the joint's angle: the motor's magnets (cogging), teeth that
    mesh, the wave generator of a harmonic drive. N is how often it repeats in one turn of the
    joint, often the gear ratio or a small multiple of it."""

    id = "torque_ripple"
    title = "Torque ripple"
    plainly = "torque that comes again at the same angles"
    equation = "τ = a·sin(N·q) + b·cos(N·q)"
    follows_angle = True
    coefficients = (Coefficient("a", "N·m"), Coefficient("b", "N·m"))
    derived = {"N": ("amplitude",)}
    shapes = (ShapeParameter("N", "cycles/rev", 3.0, 4000.0, "linear", step=0.15),)
    repeatable = True
    line_order = "N"
    signature = (
        "Against the angle the error swings evenly, equally often per turn at every speed: one "
        "line in the spectrum taken against the angle."
    )
    confounders = {
        "joint_elasticity": "both swing; a resonance keeps its frequency in hertz, ripple its "
        "number per turn",
        "position_friction": "both are tied to the angle; friction changes its sign with the "
        "direction of motion",
    }
    experiment = "Two constant speeds: at twice the speed the swings come twice as fast."
    experiment_kind = "velocity_sweep"
    source = (
        "Kennedy & Desai, Modeling and control of the Mitsubishi PA-10 robot arm harmonic drive "
        "system, IEEE/ASME Trans. Mechatronics 10 (2005)"
    )
    remedy = (
        "Inspect gear mesh, coupling and motor; what remains can be stored against the angle and "
        "compensated."
    )
    view = View("turns of a line")
    example = Example((3.0, 1.5), against="q", shape={"N": 50.0})

    def columns(self, context, joints, shape):
        phase = shape["N"] * context.q[:, joints[0]]
        return np.column_stack([np.sin(phase), np.cos(phase)])

    def starts(self, context, joints):
        # a guess; better ones are read off the residual's spectrum against the angle
        return [{"N": order} for order in USUAL]

    def values(self, coefficients, covariance, shape, shape_errors):
        out = super().values(coefficients, covariance, shape, shape_errors)
        a, b = coefficients
        size = float(np.hypot(a, b))
        gradient = np.array([a, b]) / max(size, 1e-12)
        error = float(np.sqrt(max(gradient @ covariance @ gradient, 0.0)))
        return {**out, "amplitude": Value(size, error, "N·m")}
