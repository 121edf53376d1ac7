"""The torque constant or gear ratio is off by a factor."""

from pa10d.effects.base import Coefficient, Effect, Example


class TorqueGain(Effect):
    """The torque reading is off by a factor: a wrong torque constant or gear ratio, or magnets
    that have become weaker. gain is how much too high it reads: 0.1 means 10 %. A model of before
    shows it on each joint; where the model is fitted anew, joints that carry the same bodies show
    how far their gains differ, but not which of them is right."""

    id = "torque_gain"
    title = "Torque gain"
    noun = "a torque gain that is off"
    plainly = "it reads too high or too low by a factor"
    equation = "τ = gain·τ_model"
    question = "changed"
    seen_by_shared_bodies = True
    only_against_others = (
        "A new fit shows only how gains differ: this one is against that of {others}, and as far "
        "off as that one is"
    )
    sensing = True
    uses_model = True
    coefficients = (Coefficient("gain", "1", -0.9, 9.0),)
    signature = (
        "The error is always the same share of the joint's torque, whatever the torque is for."
    )
    confounders = {"payload": "on one joint a heavier load and a weaker motor look alike"}
    experiment = "The same motion unloaded and loaded with a known weight."
    experiment_kind = "load_sweep"
    source = (
        "Gautier & Briot, Global identification of joint drive gains and dynamic parameters of "
        "robots, ASME J. Dyn. Sys. Meas. Control 136 (2014)"
    )
    remedy = (
        "Check torque constant and gear ratio in drive and profile; a gain that grows over months "
        "means weaker magnets."
    )
    example = Example((0.15,), against="total", motion="wander")

    def columns(self, context, joints, shape):
        return context.total[:, joints[0], None]
