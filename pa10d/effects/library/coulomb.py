"""Coulomb friction."""

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter


class Coulomb(Effect):
    """Dry friction of gears, seals and bearings: a constant torque against the motion, turning
    round with the direction. Close to standstill it is not a jump but a steep slope over the
    speed v0, which is found from the data as well. Where all of it builds up over a way instead
    (elsewhere 1), pre-sliding hysteresis is told in its place."""

    id = "coulomb"
    title = "Coulomb friction"
    noun = "Coulomb friction"
    plainly = "the same friction at any speed"
    equation = "τ = Fc·tanh(q̇/v0)"
    question = "textbook"
    rubs = True
    smoothed_over = "v0"
    also_changes = True
    picked_up = True
    joint_property = "friction"
    live = True
    coefficients = (Coefficient("Fc", "N·m", lower=0.0),)
    shapes = (
        ShapeParameter("v0", "rad/s", 1e-4, 1.0, "log", smoothing=True),
        ShapeParameter(
            "elsewhere",
            "1",
            0.0,
            1.0,
            "choice",
            optional=True,
            says={1.0: "builds up over a way: told with the bristles"},
        ),
    )
    signature = (
        "The error jumps when the joint turns round: as far above zero in one direction as below "
        "it in the other, at any speed."
    )
    confounders = {
        "torque_offset": "a joint that moves mostly one way cannot tell them apart",
        "load_friction": "while the load stays the same, friction from load is a constant too",
    }
    experiment = "The same path in both directions."
    experiment_kind = "velocity_sweep"
    tells_sign = True
    source = "Armstrong-Hélouvry, Dupont, Canudas de Wit (1994)"
    remedy = (
        "Part of every model. Where it has risen, look at grease, seals and brake; where it has "
        "fallen, the joint may be warmer, or worn."
    )
    example = Example((9.0,), against="dq", shape={"v0": 0.01})

    def columns(self, context, joints, shape):
        here = 1.0 - shape.get("elsewhere", 0.0)
        return (here * context.sign(context.dq[:, joints[0]], shape["v0"]))[:, None]

    def as_property(self, coefficients, shape):
        return float(coefficients[0]) if not shape.get("elsewhere") else 0.0

    def starts(self, context, joints):
        return [{"v0": v} for v in (0.003, 0.01, 0.03, 0.1, 0.3)]
