"""A joint's zero is not where the model thinks."""

from pa10d.effects.base import Coefficient, Effect, Example

SMALL = 1e-3  # rad, below which slope and secant are the same


class EncoderOffset(Effect):
    """The joint's angle reads too high by a constant, so the arm is not quite where it says it
    is. Typical after a motor was changed, a coupling slipped or the zero was taught anew."""

    id = "encoder_offset"
    title = "Encoder offset"
    noun = "an encoder offset"
    plainly = "its angle is off by a constant"
    equation = "τ = τ_rigid(q - offset) - τ_rigid(q)"
    question = "changed"
    reaches_other_joints = True
    seen_by_shared_bodies = True
    turns_joint = True
    uses_model = True
    coefficients = (Coefficient("offset", "rad", -0.5, 0.5),)
    signature = (
        "Gravity is shifted along one joint's angle; this joint and those that carry the same "
        "links are off, depending on the pose alone."
    )
    confounders = {
        "base_tilt": "at the first joint with a level axis, a shifted angle is a tilt in one "
        "direction",
        "spring": "over a part of the range the error leans with the angle, as a spring's does",
    }
    experiment = "The same motion with the neighbouring joints in other poses."
    experiment_kind = "point_to_point"
    source = "Hollerbach, Khalil & Gautier, Springer Handbook of Robotics (2016), ch. 6"
    remedy = "Calibrate the joint's zero anew; check the coupling between encoder and shaft."
    example = Example((0.04,), against="q")

    def columns(self, context, joints, shape):
        at = shape.get("at", 0.0)
        if abs(at) < SMALL:
            return -context.sensitivity(joints[0])[0][..., None]
        moved = context.q.copy()
        moved[:, joints[0]] -= at
        change = context.rigid_torque(moved, context.dq, context.ddq) - context.load
        return (change / at)[..., None]

    def relinearised(self, coefficients, shape):
        return {"at": float(coefficients[0])}
