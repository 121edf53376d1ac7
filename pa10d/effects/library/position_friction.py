"""Friction tied to a place of the joint."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, View
from pa10d.effects.context import Context

NARROWEST, NARROW = 1e-3, 0.02  # rad, m: of spots that a search begins with
WAVES_PER_TURN = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)
PHASES = (0.0, np.pi / 3, 2 * np.pi / 3)  # half a wave further is the same with A below zero


class PositionFriction(Effect):
    """Where the joint stands decides how hard it runs. Either at one place (wave 0): a worn spot,
    a tight seal, a bearing that pinches; A is the friction added at its centre qc (negative:
    missing there), w how far it reaches. Or in turns (wave 1): a shaft or a gear that is not
    round; A is added at qc and taken away half a wave further, and 1/w waves make one turn."""

    id = "position_friction"
    title = "Position-dependent friction"
    equation = "τ = A·exp(-(q - qc)²/(2·w²))·sign(q̇), or in waves τ = A·cos((q - qc)/w)·sign(q̇)"
    coefficients = (Coefficient("A", "N·m"),)
    shapes = (
        ShapeParameter("qc", "rad", -10.0, 10.0, "linear", step=lambda s: 0.6 * s["w"]),
        ShapeParameter("w", "rad", NARROWEST, 1.5, "log", step=lambda s: 0.2 if s["wave"] else 0.7),
        ShapeParameter(
            "wave",
            "1",
            0.0,
            1.0,
            "choice",
            says={0.0: "at one place", 1.0: "a wave"},
        ),
    )
    uses_model = True
    carried = True
    repeatable = True
    also_changes = True
    signature = (
        "In one range of the joint's angle friction is higher (or lower), and it opposes the "
        "motion in both directions."
    )
    confounders = {
        "torque_ripple": "both are tied to the angle; ripple does not change its sign with the "
        "direction of motion",
        "contact": "both begin at an angle; a stop pushes one way only, whatever the direction",
        "load_friction": "the load of gravity depends on the angle as well",
    }
    experiment = "Cross the range at several speeds, in both directions."
    experiment_kind = "velocity_sweep"
    source = "Armstrong-Hélouvry, Control of Machines with Friction (1991), ch. 4"
    remedy = "Inspect bearing, seal and gear teeth at that angle for dirt and wear."
    view = View("q", along=True)
    example = Example((5.0,), against="q", shape={"qc": 0.7, "w": 0.08, "wave": 0.0})

    def columns(self, context, joints, shape):
        where = self.level(context, joints, shape)
        v0 = context.softness(context.corner(joints[0]))
        return context.friction(joints[0], where, v0)[:, None]

    def level(self, context, joints, shape):
        away = (context.q[:, joints[0]] - shape["qc"]) / shape["w"]
        return np.cos(away) if shape["wave"] else np.exp(-0.5 * away**2)

    def is_itself(self, shape, low, high):
        # beyond where the joint has been a spot is a slope, and any curve's end is one
        return bool(shape["wave"]) or low <= shape["qc"] <= high

    def starts(self, context, joints):
        low, high = np.quantile(context.q[:, joints[0]], [0.03, 0.97])
        span, middle = max(high - low, 1e-3), 0.5 * (low + high)
        narrow = max(NARROWEST, min(NARROW, 0.05 * span))
        spots = [
            {"qc": float(low + span * place), "w": float(np.clip(span * width, narrow, 1.5))}
            for width, places in ((0.05, np.linspace(0, 1, 12)), (0.15, np.linspace(0, 1, 6)))
            for place in places
        ]
        waves = [
            {"qc": float(middle + phase * wide), "w": float(wide)}
            for wide in _waves(context, joints[0], span)
            for phase in PHASES
        ]
        return [{**s, "wave": 0.0} for s in spots] + [{**s, "wave": 1.0} for s in waves]


def _waves(context: Context, joint: int, span: float) -> list[float]:
    """w of the waves that a search begins with: of a shaft by its turns, of a slide by its way."""
    unit = span / (2.0 * np.pi) if context.robot.prismatic[joint] else 1.0
    return [unit / number for number in WAVES_PER_TURN]
