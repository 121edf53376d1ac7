"""Reflected inertia of a motor's rotor."""

from pa10d.effects.base import Coefficient, Effect, Example


class RotorInertia(Effect):
    """The motor's rotor resists being sped up or slowed down, as a flywheel does. Seen from the
    joint it counts with the square of the gear ratio, so that a small rotor can weigh as much as
    a link."""

    id = "rotor_inertia"
    title = "Rotor inertia"
    plainly = "the flywheel that the motor is"
    equation = "τ = Ia·q̈"
    question = "textbook"
    is_rotor = True
    also_changes = True
    joint_property = "armature"
    live = True
    coefficients = (Coefficient("Ia", "kg·m²", lower=0.0),)
    signature = "The error is proportional to the joint's own acceleration, alike in every pose."
    confounders = {
        "coupling_inertia": "both grow with acceleration in every pose; this one follows the "
        "joint's own, the other a neighbour's",
        "payload": "a load that is new resists being sped up, too, but it weighs and moves other "
        "joints' torque",
    }
    experiment = (
        "Accelerate the joint alone, in two poses in which it moves light and heavy links: "
        "the links' share changes, the rotor's does not."
    )
    experiment_kind = "single_joint"
    source = "Khalil & Dombre, Modeling, Identification and Control of Robots (2002), ch. 9"
    remedy = (
        "Nothing to repair: part of every model. A value far from the motor's data sheet hints at "
        "a wrong gear ratio. Where it has changed since the model was made, another motor, gear or "
        "brake was fitted, or something else that turns with the motor."
    )
    example = Example((3.0,), against="ddq")

    def columns(self, context, joints, shape):
        return context.ddq[:, joints[0], None]
