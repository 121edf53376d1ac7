"""Gravity comes from another direction than the model thinks."""

import numpy as np

from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.effects.base import Coefficient, Effect, Example, View

SMALL = 1e-6  # rad, where nothing is known of the angle yet
ROUNDING = 1e-6  # of gravity per rad, that a turn about the vertical seems to add
SURE = 3.0  # standard errors
ROUGH = 3.0  # times the URDF's masses at the full length of the arm: more no arm carries off-centre


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
        # an upright axis that turns first never felt gravity: what it carries off-centre is unknown
        first, axis = _turning_first(robot)
        if first >= 0 and size > 0 and abs(float(axis @ robot.gravity)) > 0.99 * size:
            out[:, first, 2] = np.cos(context.q[:, first])
            out[:, first, 3] = np.sin(context.q[:, first])
        return out

    def could_be(self, robot, coefficients, covariance):
        """What an upright first joint carries off-centre is felt by as much as the base leans: a
        wave over its angle beside no tilt at all is something else."""
        moment = _largest_moment(robot)
        if moment <= 0.0:
            return True
        tilt, wave = (float(np.linalg.norm(coefficients[k])) for k in (np.s_[:2], np.s_[2:]))
        along = coefficients[2:] / max(wave, 1e-300)
        by, wave_by = covariance[:2, :2], covariance[2:, 2:]
        leans = tilt + SURE * float(np.sqrt(np.linalg.norm(by, 2)))
        least = wave - SURE * float(np.sqrt(max(float(along @ wave_by @ along), 0.0)))
        return least <= ROUGH * moment * float(np.linalg.norm(robot.gravity)) * leans

    def relinearised(self, coefficients, shape):
        return {"rx": float(coefficients[0]), "ry": float(coefficients[1])}


def _turning_first(robot: Robot) -> tuple[int, np.ndarray]:
    """The first joint that turns, and its axis (3,) in the base's frame: slides before it, of a
    lift or of a gantry, turn nothing; -1 where all slide."""
    for j in robot.order:
        if robot.prismatic[j]:
            continue
        axis, k = robot.axis[j], int(j)
        while k >= 0:
            axis, k = robot.rotation[k] @ axis, int(robot.parent[k])
        return int(j), axis
    return -1, np.zeros(3)


def _largest_moment(robot: Robot) -> float:
    """kg·m about the first axis, of the URDF's masses with the arm stretched out."""
    away, out = np.zeros(robot.n), 0.0
    for j in robot.order:
        before = int(robot.parent[j])
        if before >= 0:
            away[j] = away[before] + np.linalg.norm(robot.translation[j])
        if robot.prismatic[j]:
            away[j] += max(abs(robot.lower[j]), abs(robot.upper[j]))
        mass, *moment = robot.parameters[j][:4]
        out += float(mass * away[j] + np.linalg.norm(moment))
    return out


def rotation(axis: int, angle: float) -> np.ndarray:
    """Rotation matrix about the x (0) or y (1) axis."""
    c, s = np.cos(angle), np.sin(angle)
    if axis == 0:
        return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
