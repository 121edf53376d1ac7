"""A gap in the transmission."""

from dataclasses import replace
from itertools import groupby

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter
from pa10d.effects.rotor import ROTOR, rotor_starts, typical_link
from pa10d.effects.twist import twisted_torque

CONTACT_HZ = 25.0  # stiffness of the flanks, as the link's natural frequency on them
CONTACT_DAMPING = 0.5
BLUR = (0.94, 0.97, 1.0, 1.03, 1.06)
"""A knock's moment depends on more digits than anybody knows: what can be predicted is the mean
over gaps that nobody could tell apart."""


class Backlash(Effect):
    """Play in the gear. Where the load changes sides the teeth part, and the link moves freely
    through the gap until the opposite teeth hit. b is half the gap; a share near 1 confirms that
    the gap explains the error. Where a rigid model cannot tell rotor from link (axes that are
    fixed), the gap can: rotor is the inertia on the motor's side."""

    id = "backlash"
    title = "Backlash"
    plainly = "play in the gear"
    equation = (
        "M_link·δ̈ + teeth(|δ| > b) = τ_link(q - δ),  M_link = M_jj - rotor, "
        "τ_link = τ_load - rotor·q̈,  Δτ = share·(τ_link(q - δ) - τ_link(q))"
    )
    reaches_other_joints = True
    starts_by_own_equation = True  # many starts, and a knock is felt at home first
    uses_model = True
    escapes_demo = "the knocks behind a gap drown its own torque"
    coefficients = (Coefficient("share", "1", 0.5, 1.25, whole_at_one=True),)
    shapes = (
        ShapeParameter("b", "rad", 5e-5, 0.1, "log", blur=float(np.std(BLUR)), step=0.12),
        replace(ROTOR, blur=float(np.std(BLUR))),  # what moves the knocks as a wider gap does
    )
    derived = {"rotor": ("b",)}  # it knocks where a gap lets it
    signature = (
        "Each time the joint's load changes sides, no torque passes for a moment; then comes a "
        "knock. In between the error is small."
    )
    confounders = {
        "presliding_hysteresis": "both act over a distance; that one whenever the joint turns "
        "round, a gap only where the load changes sides",
        "joint_elasticity": "both let the link lag when the load changes sides",
    }
    experiment = "Slow to-and-fro motion through the pose in which gravity changes sides."
    experiment_kind = "reversals"
    source = "Nordin & Gutman, Controlling mechanical systems with backlash, Automatica 38 (2002)"
    remedy = "Adjust the gear's preload; inspect teeth, keys and couplings for wear."
    remembers = "how far the link lags behind and how fast (apart: at rest under its load)"
    example = Example((1.0,), against="load", shape={"b": 0.01}, motion="across_upright")

    def columns(self, context, joints, shape):
        return self.columns_of(context, joints, [shape])

    def columns_of(self, context, joints, shapes, own=False):
        made = []
        # what shares a rotor is integrated side by side
        for rotor, alike in groupby(shapes, key=lambda shape: shape.get("rotor", 0.0)):
            inertia = typical_link(context, joints[0], rotor)
            stiffness = float(inertia * (2 * np.pi * CONTACT_HZ) ** 2)
            gaps = [[shape["b"] * factor for factor in BLUR] for shape in alike]
            made.append(
                twisted_torque(context, joints[0], stiffness, CONTACT_DAMPING, gaps, rotor, own)
            )
        return np.concatenate(made, axis=-1)

    def starts(self, context, joints):
        # closely: a gap a quarter too wide or too narrow has its knocks at other moments
        return [
            {"b": float(b)} | rotor
            for rotor in rotor_starts(context, joints[0], (0.1, 0.25, 0.4, 0.6, 0.8))
            for b in np.geomspace(4e-4, 0.03, 17)
        ]
