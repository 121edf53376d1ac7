"""A constant torque."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example


class TorqueOffset(Effect):
    """The torque reading is off by a constant: a current sensor that does not show zero when no
    current flows, or something that always pulls the same way."""

    id = "torque_offset"
    title = "Torque offset"
    noun = "a torque offset"
    plainly = "it reads too high or too low by a constant"
    equation = "τ = offset"
    also_changes = True
    picked_up = True
    live = True
    coefficients = (Coefficient("offset", "N·m"),)
    signature = "All of the error is shifted by the same amount, in both directions, in every pose."
    confounders = {
        "coulomb": "seen in one direction of motion only, friction is a constant",
        "coulomb_asymmetry": "one direction that costs more by the same amount at every speed "
        "is an offset",
        "spring": "over a short range of angles a spring pulls almost constantly",
    }
    experiment = "Hold several poses: gravity and springs change with the pose, an offset does not."
    experiment_kind = "point_to_point"
    source = "Swevers et al., IEEE Trans. Robotics and Automation 13 (1997)"
    remedy = "Set the current sensor to zero with the motor off; check that the brake opens fully."
    example = Example((5.0,), against="dq")

    def columns(self, context, joints, shape):
        return np.ones((len(context.t), 1))
