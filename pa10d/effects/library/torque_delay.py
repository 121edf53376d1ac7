"""The torque channel is late against position."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, View
from pa10d.measurement.signals import delayed, through_channel
from pa10d.measurement.torque_filter import DELAYS, FIRST_ORDER, TorqueFilter


class TorqueDelay(Effect):
    """The torque reading of this joint comes later than its angle, by Td: another bus, a slower
    current loop, a filter in the drive. Where it is smoothed, it has passed a low-pass of first
    order that makes what is slow late by Td, and what is fast smaller."""

    id = "torque_delay"
    title = "Torque delay"
    noun = "a torque that is measured late"
    equation = (
        "τ = τ_late - τ_model,  τ_late = τ_model(t - Td), or smoothed: "
        "Td·dτ_late/dt + τ_late = τ_model"
    )
    sensing = True
    uses_model = True
    commanded = False  # a late sensor is no torque
    coefficients = (Coefficient("Td", "s", 0.0, 0.2),)
    shapes = (
        ShapeParameter(
            "smoothed",
            "1",
            0.0,
            1.0,
            "choice",
            optional=True,
            says={0.0: "late as a whole", 1.0: "behind a low-pass of first order"},
        ),
    )
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
        rate = 1.0 / context.dt
        late = delayed(total[:, None], at, rate)
        if shape.get("smoothed"):
            late = through_channel(late, TorqueFilter(FIRST_ORDER, at / DELAYS[FIRST_ORDER]), rate)
        return (late - total[:, None]) / at

    def starts(self, context, joints):
        return [{}, {"smoothed": 1.0}]

    def relinearised(self, coefficients, shape):
        return dict(shape) | {"at": float(coefficients[0])}
