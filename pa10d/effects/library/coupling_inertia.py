"""A rotor that turns with two joints."""

import numpy as np

from pa10d.effects.base import Coefficient, Effect, Example


class CouplingInertia(Effect):
    """A rotor or wheel turns with two joints at once, as in a differential wrist or behind a
    shared belt. Speeding up one joint then pushes or pulls the other."""

    id = "coupling_inertia"
    title = "Coupled rotor inertia"
    plainly = "one joint pushes when the other speeds up"
    equation = "τ_i = Ia_ij·q̈_j,  τ_j = Ia_ij·q̈_i"
    scope = "pair"
    reaches_other_joints = True
    coefficients = (Coefficient("Ia_ij", "kg·m²"),)
    signature = (
        "One joint's error is proportional to the other joint's acceleration, alike in every pose."
    )
    confounders = {
        "rotor_inertia": "both grow with acceleration in every pose; this one follows a "
        "neighbour's, the other the joint's own",
        "coupling_friction": "both tie two joints together; one follows the other's acceleration, "
        "one its speed",
    }
    experiment = "Accelerate both joints in several poses: coupling by links changes, this stays."
    experiment_kind = "excitation"
    source = (
        "Janot, Vandanjon & Gautier, A generic instrumental variable approach for industrial "
        "robot identification, IEEE Trans. Control Systems Technology 22 (2014)"
    )
    remedy = "Nothing to repair: it belongs to such drives. Keep it in the model."
    example = Example((0.4,), against="other_ddq", joints=(5, 6))

    def columns(self, context, joints, shape):
        i, j = joints
        out = np.zeros_like(context.q, shape=(*context.q.shape, 1))
        out[:, i, 0] = context.ddq[:, j]
        out[:, j, 0] = context.ddq[:, i]
        return out
