"""A series spring between rotor and link."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, Value, View
from pa10d.effects.rotor import LIGHTEST, ROTOR, link_inertia, rotor_starts
from pa10d.effects.swing import DAMPED
from pa10d.effects.twist import twisted_torque

STIFFNESS = 0.1, 1e7  # N·m/rad, N/m: a finger's tendon, a large robot's first gear


class JointElasticity(Effect):
    """The gear gives under load like a stiff spring. The link lags behind the motor, where the
    angle is measured, and can swing against it at a frequency of its own. K is the spring's
    stiffness, C its damping, zeta the same as a ratio, at the median of the link's inertia over
    the joints' ranges; a share near 1 confirms that the lag explains the error. Where a rigid model
    cannot tell rotor from link (axes that are fixed), the spring can: rotor is the inertia on the
    motor's side."""

    id = "joint_elasticity"
    title = "Joint elasticity"
    noun = "elasticity"
    plainly = "the gear gives like a spring"
    equation = (
        "M_link·δ̈ + C·δ̇ + K·δ = τ_link(q - δ),  M_link = M_jj - rotor, τ_link = τ_load - rotor·q̈,  "
        "Δτ = share·(τ_link(q - δ) - τ_link(q))"
    )
    reaches_other_joints = True
    series_spring = True
    uses_model = True
    # with a free share a spring that is too stiff or too soft would do as well
    coefficients = (Coefficient("share", "1", 0.97, 1.03, whole_at_one=True),)
    shapes = (
        ShapeParameter("K", "N·m/rad", *STIFFNESS, "log"),
        ShapeParameter("zeta", "1", *DAMPED, "log"),
        ROTOR,
    )
    derived = {"zeta": ("K",), "rotor": ("K",)}  # of a mode: where that is, K says
    signature = (
        "The error grows with acceleration and its changes, and is largest near one frequency in "
        "hertz, whatever the speed; neighbouring joints feel it, too."
    )
    confounders = {
        "torque_delay": "both grow with changes of acceleration; a delay has no frequency of its "
        "own",
        "torque_ripple": "both swing; ripple keeps its number per turn, a resonance its frequency "
        "in hertz",
        "backlash": "both let the link lag when the load changes sides",
    }
    experiment = "A chirp: to and fro with slowly rising frequency, through the resonance."
    experiment_kind = "chirp"
    source = "Spong, Modeling and control of elastic joint robots (1987)"
    remedy = (
        "Check the flexspline (the thin cup of a harmonic drive), couplings and all bolts; keep "
        "motion and controller slower than the resonance."
    )
    view = View(over_frequency=True)
    remembers = "how far the link lags behind and how fast (apart: at rest under its load)"
    example = Example(
        (1.0,), against="frequency", shape={"K": 2000.0, "zeta": 0.06}, motion="chirp"
    )

    def beside_link(self, values, inertia):
        stiffness, zeta, rotor = values["K"], values["zeta"], values.get("rotor")
        link = max(inertia - (rotor.value if rotor else 0.0), LIGHTEST * inertia)
        damping = 2.0 * zeta.value * float(np.sqrt(stiffness.value * link))
        parts = [zeta.std_error / zeta.value, 0.5 * stiffness.std_error / stiffness.value]
        if rotor:
            parts.append(0.5 * rotor.std_error / link)
        known = zeta.determined and stiffness.determined
        error = damping * float(np.linalg.norm(parts))
        return {**values, "C": Value(damping, error, "N·m·s/rad", determined=known)}

    def columns(self, context, joints, shape):
        return self._column(context, joints, shape, closely=True)

    def columns_of(self, context, joints, shapes, own=False):
        return np.concatenate([self._column(context, joints, s, own) for s in shapes], axis=-1)

    def _column(self, context, joints, shape, own=False, closely=False):
        rotor = shape.get("rotor", 0.0)
        return twisted_torque(
            context, joints[0], shape["K"], shape["zeta"], rotor=rotor, own=own, closely=closely
        )

    def starts(self, context, joints):
        out = []
        for rotor in rotor_starts(context, joints[0], (0.1, 0.35, 0.7)):
            inertia = float(np.median(link_inertia(context, joints[0], rotor.get("rotor", 0.0))))
            out += [
                {"K": float(np.clip(inertia * (2 * np.pi * f) ** 2, *STIFFNESS)), "zeta": 0.05}
                | rotor
                for f in (2.0, 3.0, 4.5, 6.5, 9.0, 13.0, 20.0)
            ]
        return out
