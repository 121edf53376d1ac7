"""Gravity comes from another direction than the model thinks."""

import numpy as np

from pa10d.dynamics import inverse_dynamics
from pa10d.effects.base import Coefficient, Effect, Example, View

SMALL = 1e-6  # rad, where nothing is known of the angle yet
ROUNDING = 1e-6  # of gravity per rad, that a turn about the vertical seems to add


class BaseTilt(Effect):
    """The base does not stand as the model thinks, so gravity pulls from a slightly different
    direction. rx and ry are the angles by which it is turned about its own x and y axes."""

    id = "base_tilt"
    title = "Base tilt"
    noun = "a tilted base"
    equation = "τ = τ_gravity(turned by rx, ry) - τ_gravity, with the first link's own unknowns"
    scope = "robot"
    question = "changed"
    reaches_other_joints = True
    seen_by_shared_bodies = True
    uses_model = True
    coefficients = (
        Coefficient("rx", "rad", -0.5, 0.5),
        Coefficient("ry", "rad", -0.5, 0.5),
        Coefficient("first_cos", "N·m", nuisance=True),
        Coefficient("first_sin", "N·m", nuisance=True),
    )
    signature = (
        "The error depends on the pose alone, as if the gravity of the whole arm were turned; an "
        "upright first joint, which never felt gravity, now does."
    )
    confounders = {
        "encoder_offset": "at the first joint with a level axis, a shifted angle is a tilt in one "
        "direction",
        "payload": "both change gravity in several joints",
    }
    experiment = (
        "The same poses with the first joint turned by 180°: what a tilt causes changes its sign, "
        "what an encoder offset causes does not."
    )
    experiment_kind = "point_to_point"
    source = "Hollerbach, Khalil & Gautier, Springer Handbook of Robotics (2016), ch. 6"
    remedy = "Level the base, or enter its orientation in the profile."
    view = View()
    example = Example((0.03, 0.02, 0.0, 0.0), against="q", motion="wander", joints=(2,))

    def columns(self, context, joints, shape):
        robot, zero = context.robot, np.zeros_like(context.q)
        size = float(np.linalg.norm(robot.gravity))
        out = np.zeros_like(context.q, shape=(*context.q.shape, 4))
        for i in range(2):
            at = shape.get("rx" if i == 0 else "ry", 0.0) or SMALL
            # turning the base by an angle turns gravity back by it, as the base sees it
            turned = rotation(i, at).T @ robot.gravity
            pulls = (turned - robot.gravity) / at
            if np.linalg.norm(pulls) <= ROUNDING * size:  # about the vertical, as on a wall
                continue
            tilted = robot.with_gravity(pulls)
            out[..., i] = inverse_dynamics(tilted, context.rigid, context.q, zero, zero)
        # a vertical first axis never felt gravity: what it carries off-centre is unknown
        first = int(robot.order[0])
        along = abs(float(robot.rotation[first] @ robot.axis[first] @ robot.gravity))
        if size > 0 and along > 0.99 * size and not robot.prismatic[first]:
            out[:, first, 2] = np.cos(context.q[:, first])
            out[:, first, 3] = np.sin(context.q[:, first])
        return out

    def relinearised(self, coefficients, shape):
        return {"rx": float(coefficients[0]), "ry": float(coefficients[1])}


def rotation(axis: int, angle: float) -> np.ndarray:
    """Rotation matrix about the x (0) or y (1) axis."""
    c, s = np.cos(angle), np.sin(angle)
    if axis == 0:
        return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
