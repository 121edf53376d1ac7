"""Viscous friction."""

from pa10d.effects.base import Coefficient, Effect, Example


class Viscous(Effect):
    """The lubricant resists being sheared: twice the speed, twice the torque."""

    id = "viscous"
    title = "Viscous friction"
    plainly = "friction in proportion to the speed"
    equation = "τ = Fv·q̇"
    question = "textbook"
    rubs = True
    also_changes = True
    picked_up = True
    joint_property = "damping"
    live = True
    coefficients = (Coefficient("Fv", "N·m·s/rad", lower=0.0),)
    signature = "Against the joint's speed the error is a straight line through zero."
    confounders = {
        "nonlinear_viscous": "over a narrow range of speeds a curve looks like a line",
        "thermal_friction": "its mean over a run is viscous friction",
    }
    experiment = "Constant speeds over the whole range, in both directions."
    experiment_kind = "velocity_sweep"
    source = "Armstrong-Hélouvry, Dupont, Canudas de Wit (1994)"
    remedy = (
        "Part of every model. Where it has risen, the joint is colder or its grease is older than "
        "when the model was made."
    )
    example = Example((12.0,), against="dq")

    def columns(self, context, joints, shape):
        return context.dq[:, joints[0], None]
