"""Friction as a function of displacement since the last reversal."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, Value, View

SLIDES = 0.01  # rad/s: where nothing is known of the way, faster than that it slides


class PreslidingHysteresis(Effect):
    """Before two surfaces slip they bend, like the bristles of two brushes. After the joint has
    turned round, friction therefore builds up over a short distance zs instead of jumping. F is
    the friction that behaves so, sigma0 = F/zs the stiffness felt in very small motion. Bristles
    that are damped resist bending by its speed, too: sigma1 = lag·sigma0."""

    id = "presliding_hysteresis"
    title = "Pre-sliding hysteresis"
    plainly = "after each turn friction builds up over a short way"
    equation = "τ = F·(z + lag·dz/dt), dz/dt = q̇·(1 - z·sign(q̇))/zs  (LuGre; Dahl where lag = 0)"
    coefficients = (Coefficient("F", "N·m", lower=0.0),)
    shapes = (
        ShapeParameter("zs", "rad", 1e-4, 0.2, "log"),
        ShapeParameter(
            "damped",
            "1",
            0.0,
            1.0,
            "choice",
            optional=True,
            says={0.0: "bristles without damping", 1.0: "damped bristles"},
        ),
        ShapeParameter("lag", "s", 1e-4, 0.5, "log", optional=True),
    )
    signature = (
        "Each time the joint turns round the error draws a loop against the angle; the loop is as "
        "wide in fast motion as in slow."
    )
    confounders = {
        "stribeck": "both act just after the joint has turned round; this one follows the "
        "distance travelled, the other the speed",
        "backlash": "both act over a distance after turning round; across a gap no torque passes "
        "at all, and only where the load changes sides",
    }
    experiment = "Small to-and-fro motions of several sizes, some smaller than zs."
    experiment_kind = "reversals"
    source = (
        "Dahl, Solid friction damping of mechanical vibrations (1976); Canudas de Wit et al., A "
        "new model for control of systems with friction (1995)"
    )
    remedy = (
        "Nothing to repair as such. A distance that has grown since the last identification "
        "hints at wear."
    )
    derived = {"sigma0": ("F", "zs"), "sigma1": ("F", "zs", "lag")}
    carried = True
    builds_up_over = "zs"
    damped_over = "lag"
    joint_property = "friction"
    uses_model = True
    remembers = "the way since the joint last turned round (apart: it slides)"
    view = View("travel", along=True, near=("zs", 12.0), over_time=True)
    example = Example((8.0,), against="q", shape={"zs": 0.004}, motion="reversals")

    def columns(self, context, joints, shape):
        j = joints[0]
        if context.apart:
            return context.sign(context.dq[:, j], SLIDES)[:, None]
        level = self.level(context, joints, shape)
        return context.bristles(j, level, shape["zs"], shape.get("lag", 0.0))[:, None]

    def level(self, context, joints, shape):
        return np.ones(len(context.q))

    def starts(self, context, joints):
        plain = [{"zs": z} for z in (5e-4, 2e-3, 5e-3, 0.015, 0.04)]
        return plain + [s | {"damped": 1.0, "lag": lag} for s in plain for lag in (0.005, 0.05)]

    def values(self, coefficients, covariance, shape, shape_errors):
        out = super().values(coefficients, covariance, shape, shape_errors)
        out["sigma0"] = _product(out, {"F": 1.0, "zs": -1.0}, "N·m/rad")
        if "lag" in out:
            out["sigma1"] = _product(out, {"F": 1.0, "zs": -1.0, "lag": 1.0}, "N·m·s/rad")
        return out


def _product(of: dict[str, Value], powers: dict[str, float], unit: str) -> Value:
    """Of estimates to these powers, whose errors are small and taken as independent."""
    value = float(np.prod([of[name].value ** power for name, power in powers.items()]))
    relative = np.hypot.reduce(
        [of[name].std_error / max(abs(of[name].value), 1e-12) for name in powers]
    )
    return Value(value, float(abs(value) * relative), unit)
