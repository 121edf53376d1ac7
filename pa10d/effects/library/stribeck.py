"""Stribeck friction."""

import numpy as np

from pa10d.effects.base import (
    Coefficient,
    Effect,
    Example,
    ShapeParameter,
    View,
    speed_quantiles,
)


class Stribeck(Effect):
    """At very low speed the film of lubricant is thin and the surfaces touch, so friction is
    higher; as the joint gets faster the film carries, and friction falls to its usual level.
    Named after Richard Stribeck, who measured it in bearings. Fs is the extra friction at the
    lowest speeds, vs the speed over which it fades."""

    id = "stribeck"
    title = "Stribeck friction"
    noun = "Stribeck friction"
    plainly = "extra friction at low speed"
    equation = "τ = Fs·exp(-(|q̇|/vs)^δ)·sign(q̇)"
    uses_model = True
    carried = True
    coefficients = (Coefficient("Fs", "N·m", lower=0.0),)
    shapes = (
        ShapeParameter("vs", "rad/s", 2e-3, 1.0, "log"),
        ShapeParameter("delta", "1", 0.5, 2.0, "linear", step=0.5, usual=2.0),
    )
    also_changes = True
    signature = (
        "More friction at low speed, in both directions: a bump on either side of zero speed that "
        "is gone above two to three times vs."
    )
    confounders = {
        "presliding_hysteresis": "both act just after the joint has turned round; this one "
        "follows the speed, the other the distance travelled",
        "nonlinear_viscous": "a bump as wide as all speeds measured bends the whole curve, as a "
        "power of the speed does",
    }
    experiment = (
        "Slow constant speeds in both directions, from a fraction of vs to several times vs."
    )
    experiment_kind = "velocity_sweep"
    source = "Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), sec. 2.1"
    remedy = (
        "Check kind and age of the lubricant. Keep the effect in the model where the arm has to "
        "move slowly and evenly."
    )
    derived = {"delta": ("vs",)}
    view = View("dq", near=("vs", 5.0))
    example = Example((6.0,), against="dq", shape={"vs": 0.06, "delta": 1.0})

    def columns(self, context, joints, shape):
        sharp = min(0.05 * shape["vs"], context.corner(joints[0]))
        level = self.level(context, joints, shape)
        return context.friction(joints[0], level, context.softness(sharp))[:, None]

    def level(self, context, joints, shape):
        return np.exp(-((np.abs(context.dq[:, joints[0]]) / shape["vs"]) ** shape["delta"]))

    def starts(self, context, joints):
        # well inside the speeds visited: a bump as wide as the data is another effect
        top = speed_quantiles(context, joints[0], [0.95])[0]
        speeds = [top * share for share in (0.02, 0.05, 0.1, 0.2, 0.35)]
        return [
            {"vs": float(np.clip(v, 2e-3, 1.0)), "delta": d} for v in speeds for d in (1.0, 2.0)
        ]
