"""The torque channel is late against position."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, View
from pa10d.measurement.signals import delayed


class TorqueDelay(Effect):
    """The torque reading of this joint comes later than its angle, by Td: another bus, a slower
    current loop, a filter in the drive."""

    id = "torque_delay"
    title = "Torque delay"
    noun = "a torque that is measured late"
    equation = "τ = τ_model(t - Td) - τ_model(t)"
    sensing = True
    uses_model = True
    commanded = False  # a late sensor is no torque
    coefficients = (Coefficient("Td", "s", 0.0, 0.2),)
    signature = (
        "The error follows the slope of the torque: large where torque changes fast, zero where "
        "it peaks."
    )
    confounders = {
        "joint_elasticity": "both grow with changes of acceleration; a spring has a frequency of "
        "its own"
    }
    experiment = (
        "A chirp at two amplitudes: what a delay causes grows evenly with frequency, without a "
        "peak."
    )
    experiment_kind = "chirp"
    source = "Ljung, System Identification: Theory for the User (1999)"
    remedy = "Line up the time stamps of torque and angle; look for a filter in the drive."
    remembers = "the torque a moment ago (apart: it does not change)"
    view = View("rate", over_frequency=True)
    example = Example((0.02,), against="rate", motion="wander")

    def columns(self, context, joints, shape):
        if context.apart:
            return np.zeros((len(context.q), 1))
        total, at = context.total[:, joints[0]], shape.get("at", 0.0)
        if at < 0.1 * context.dt:
            return -np.gradient(total, context.dt)[:, None]
        return (delayed(total[:, None], at, 1.0 / context.dt) - total[:, None]) / at

    def relinearised(self, coefficients, shape):
        return {"at": float(coefficients[0])}
