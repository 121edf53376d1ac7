"""Friction on the sum or difference of two joints' speeds."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example, ShapeParameter, View

SHARP = 1e-3
"""rad/s over which the sign is smoothed where the data do not say. What slips turns round while
both joints move, so those samples are not left out as a joint's own reversals are: a sign that is
blunter or sharper than the drive's leaves an error there."""
SOFT = 0.017
"""rad/s, where its search begins otherwise: the middle of its range, on its scale."""


class CouplingFriction(Effect):
    """Two joints share a gear, a belt or a differential. What rubs there turns with the sum of
    their speeds (ratio 1) or the difference (ratio -1): one joint feels friction when the other
    moves. A differential with two motors has both. F is its constant part, D the part that grows
    with speed (of a differential: the sum's less the difference's), left out where the motion
    cannot tell it (viscous 0). v0: the speed over which the sign turns round, where it shows."""

    id = "coupling_friction"
    title = "Coupled friction"
    plainly = "one joint rubs when the other moves"
    equation = "τ_i = F·tanh(v/v0) + D·v,  τ_j = ratio·τ_i,  v = q̇_i + ratio·q̇_j"
    scope = "pair"
    one_of_each = "ratio"  # of a differential both motors rub
    reaches_other_joints = True
    coefficients = (Coefficient("F", "N·m", lower=0.0), Coefficient("D", "N·m·s/rad", lower=0.0))
    shapes = (
        ShapeParameter(
            "ratio",
            "1",
            -1.0,
            1.0,
            "choice",
            says={
                1.0: "rubs at the sum of their speeds",
                -1.0: "rubs at the difference of their speeds",
            },
        ),
        ShapeParameter(
            "viscous",
            "1",
            0.0,
            1.0,
            "choice",
            optional=True,
            says={0.0: "no part of it grows with speed", 1.0: "a part of it grows with speed"},
        ),
        ShapeParameter("v0", "rad/s", 1e-3, 0.3, "log", smoothing=True, optional=True),
    )
    signature = (
        "One joint shows friction that follows the other's speed, even while it stands or moves "
        "evenly itself."
    )
    confounders = {
        "coupling_inertia": "both tie two joints together; one follows the other's speed, one its "
        "acceleration"
    }
    experiment = "Move one joint of the pair at a time."
    experiment_kind = "single_joint"
    source = (
        "Guedelha, Traversaro & Pucci, Identification of motor parameters on coupled joints (2019)"
    )
    remedy = (
        "Such drives have it: keep it in the model. Where it has grown, look at belt tension and "
        "the shared gear's lubrication."
    )
    view = View("slip")
    example = Example((4.0, 1.0), against="other_dq", shape={"ratio": 1.0}, joints=(5, 6))

    def columns(self, context, joints, shape):
        i, j = joints
        v = self.slips(context, joints, shape)
        both = np.column_stack(
            [
                context.sign(v, context.softness(shape.get("v0", SHARP))),
                shape.get("viscous", 1.0) * v,
            ]
        )
        out = np.zeros_like(context.q, shape=(*context.q.shape, 2))
        out[:, i] = both
        out[:, j] = shape["ratio"] * both
        return out

    def slips(self, context, joints, shape):
        i, j = joints
        return context.dq[:, i] + shape["ratio"] * context.dq[:, j]

    def starts(self, context, joints):
        ratios = [{"ratio": r} for r in (1.0, -1.0)]
        sharp = ratios + [r | {"viscous": 0.0} for r in ratios]
        return sharp + [start | {"v0": SOFT} for start in sharp]

    def values(self, coefficients, covariance, shape, shape_errors):
        out = super().values(coefficients, covariance, shape, shape_errors)
        if not shape.get("viscous", 1.0):
            del out["D"]
        return out
