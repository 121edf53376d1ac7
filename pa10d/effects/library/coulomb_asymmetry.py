"""Friction that differs by direction."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example


class CoulombAsymmetry(Effect):
    """Going one way costs more than going back: gear flanks, seal lips and preloaded bearings
    need not be alike on both sides. dFc and dFv are half the difference between the directions of
    the constant part and of the part that grows with speed."""

    id = "coulomb_asymmetry"
    title = "Direction-dependent friction"
    equation = "τ = dFc + dFv·|q̇|"
    coefficients = (Coefficient("dFc", "N·m"), Coefficient("dFv", "N·m·s/rad"))
    signature = (
        "Against speed, the branch of one direction is not the mirror image of the other: it lies "
        "higher or climbs faster."
    )
    confounders = {
        "torque_offset": "if the directions differ by the same amount at every speed, it is an "
        "offset"
    }
    experiment = (
        "Several constant speeds in both directions: an offset shifts all of them alike, a "
        "steeper side shows more the faster it goes."
    )
    experiment_kind = "velocity_sweep"
    source = "Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), sec. 2"
    remedy = "Compare both flanks of the gear teeth; check seal lips and the bearings' preload."
    example = Example((2.0, 6.0), against="dq")

    def columns(self, context, joints, shape):
        speed = np.abs(context.dq[:, joints[0]])
        return np.column_stack([np.ones_like(speed), speed])
