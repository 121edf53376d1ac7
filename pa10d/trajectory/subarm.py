"""The arm that remains when some joints are held: their links become part of their carriers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot

Array = NDArray[np.float64]

_TENSOR = np.array([[4, 5, 7], [5, 6, 8], [7, 8, 9]])  # places of the tensor in ten parameters


def sub_arm(robot: Robot, joints: NDArray[np.int64], pose: Array) -> Robot:
    """The arm of ``joints`` (0-based, any order) alone, all others held at ``pose`` (n,).

    Its torque is exactly that of the whole arm for motions of these joints. Only the arrays are
    those of the smaller arm; ``urdf`` is left empty because no text describes it.
    """
    chosen = np.asarray(joints, dtype=np.int64)
    place = {int(j): k for k, j in enumerate(chosen)}
    parameters = robot.parameters[chosen].copy()
    rotation, translation = robot.rotation[chosen].copy(), robot.translation[chosen].copy()
    parent = np.full(len(chosen), -1, dtype=np.int64)
    for j in range(robot.n):
        carrier, turn, shift = _carrier(robot, j, place, pose)
        if j in place:
            k = place[j]
            parent[k] = -1 if carrier < 0 else place[carrier]
            rotation[k] = turn @ robot.rotation[j]
            translation[k] = turn @ robot.translation[j] + shift
        elif carrier >= 0:
            own_turn, own_shift = _placement(robot, j, pose)
            body = moved(robot.parameters[j], turn @ own_turn, turn @ own_shift + shift)
            parameters[place[carrier]] += body
    return replace(
        robot,
        joint_names=tuple(robot.joint_names[j] for j in chosen),
        parent=parent,
        order=np.array([place[int(j)] for j in robot.order if int(j) in place], dtype=np.int64),
        rotation=rotation,
        translation=translation,
        axis=robot.axis[chosen],
        prismatic=robot.prismatic[chosen],
        parameters=parameters,
        lower=robot.lower[chosen],
        upper=robot.upper[chosen],
        velocity=robot.velocity[chosen],
        effort=robot.effort[chosen],
        acceleration=robot.acceleration[chosen],
        gain_error=None if robot.gain_error is None else robot.gain_error[chosen],
        urdf="",
    )


def _carrier(
    robot: Robot, joint: int, chosen: dict[int, int], pose: Array
) -> tuple[int, Array, Array]:
    """The nearest chosen joint below, and where the joint's parent frame lies in its frame."""
    turn, shift = np.eye(3), np.zeros(3)
    above = int(robot.parent[joint])
    while above >= 0 and above not in chosen:
        own_turn, own_shift = _placement(robot, above, pose)
        turn, shift = own_turn @ turn, own_turn @ shift + own_shift
        above = int(robot.parent[above])
    return above, turn, shift


def _placement(robot: Robot, joint: int, pose: Array) -> tuple[Array, Array]:
    """A joint's frame in its parent's, at the pose."""
    fixed, axis, angle = robot.rotation[joint], robot.axis[joint], float(pose[joint])
    if robot.prismatic[joint]:
        return fixed, robot.translation[joint] + fixed @ axis * angle
    cross = np.cross(np.eye(3), axis)  # cross @ v = axis × v
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    return fixed @ turn, robot.translation[joint]


def moved(body: Array, turn: Array, shift: Array) -> Array:
    """Standard parameters (10,) of a body seen from another frame: x' = turn·x + shift.

    The pseudo-inertia [[½tr(I)·1 - I, mc], [mcᵀ, m]] transforms as T·J·Tᵀ (Wensing et al. 2018).
    """
    tensor = body[_TENSOR]
    pseudo = np.empty((4, 4))
    pseudo[:3, :3] = 0.5 * np.trace(tensor) * np.eye(3) - tensor
    pseudo[:3, 3] = pseudo[3, :3] = body[1:4]
    pseudo[3, 3] = body[0]
    to = np.eye(4)
    to[:3, :3], to[:3, 3] = turn, shift
    seen = to @ pseudo @ to.T
    sigma = seen[:3, :3]
    tensor = np.trace(sigma) * np.eye(3) - sigma
    return np.concatenate(
        [[seen[3, 3]], seen[:3, 3], tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]]
    )
