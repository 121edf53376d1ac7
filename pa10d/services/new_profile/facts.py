"""What a URDF says of an arm that is to be moved, what it leaves open, and what to doubt."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from pa10d.common.urdf_joints import carried_by, followers
from pa10d.common.urdf_xml import urdf_root
from pa10d.dynamics.environment import Environment
from pa10d.dynamics.inverse import inverse_dynamics
from pa10d.dynamics.mass import mass_matrices
from pa10d.dynamics.robot import STANDARD_GRAVITY, Robot, robot_from_urdf
from pa10d.trajectory.limits import POSITION_MARGIN
from pa10d.trajectory.poses import Surroundings

Array = NDArray[np.float64]

TRIES = 2000  # poses among which one is looked for that meets nothing
POSES = 200  # drawn at random, to see how heavy the arm is
IN_DEGREES = 50.0  # rad either way, eight turns: more than any joint with a limit has
BRISK = 10.0  # rad/s² (m/s²)
STRONGEST = 100.0  # times what moves the arm briskly, of its weakest joint
ALIKE = 3  # links in a row: two of a pair may be built alike
TRIANGLE = 1e-6  # share by which rounded digits may break the triangle of principal moments


@dataclass(frozen=True)
class ArmFacts:
    """weight: (n,) N·m (N), the most that gravity asks of each joint; inertia: (n,) kg·m² (kg), the
    most that it turns (pushes); doubts: sentences; home: (n,) rad (m) a pose to begin at, None
    where zero (or mid-range) will do; hangs: whether no pose keeps clear of a floor at its base.
    """

    robot: Robot
    weight: Array
    inertia: Array
    doubts: list[str]
    home: Array | None
    hangs: bool = False


def facts_of(urdf: Path, joints: Sequence[str] | None = None) -> ArmFacts:
    """Read the URDF for the arm standing upright; UserError where it is none.

    joints: names, in order; None: every movable one."""
    robot = robot_from_urdf(urdf, None if joints is None else list(joints), STANDARD_GRAVITY)
    doubts: list[str] = []
    if joints is None:
        robot, doubts = _that_can_move(urdf, robot)
    poses = _poses(robot)
    still = np.zeros_like(poses)
    weight = np.abs(inverse_dynamics(robot, robot.parameters, poses, still, still)).max(axis=0)
    turned = np.diagonal(mass_matrices(robot, poses), axis1=1, axis2=2).max(axis=0)
    doubts += [
        *_follow(urdf, robot),
        *_doubts(robot),
        *_far_too_strong(robot, weight + BRISK * turned),
    ]
    home, hangs = _home(robot), False
    if home is None and not _is_free(robot):
        hung = replace(robot, environment=Environment(floor=None))
        home = _home(hung)
        hangs = home is not None or _is_free(hung)
    if hangs:
        doubts.append(
            "no pose keeps the arm 3 cm above a floor at the height of its base: no floor is "
            "assumed; say in 'environment' where it is"
        )
    return ArmFacts(robot, weight, turned, doubts, home, hangs)


def _that_can_move(urdf: Path, robot: Robot) -> tuple[Robot, list[str]]:
    """Without joints that no plan has room for, such as the fingers of a gripper; and what to ask
    whoever has a robot of several arms."""
    robot, said = _without_grippers(urdf, robot)
    narrow = robot.upper - robot.lower <= 2 * POSITION_MARGIN
    if narrow.any() and not narrow.all():
        left = [name for name, flag in zip(robot.joint_names, narrow, strict=True) if flag]
        kept = [name for name in robot.joint_names if name not in left]
        robot = robot_from_urdf(urdf, kept, STANDARD_GRAVITY)
        said.append(
            f"{', '.join(left)} left out: its range leaves no room for motion, so it is held where "
            "it is zero; --joints names others"
        )
    behind = np.bincount(np.asarray(robot.parent) + 1, minlength=robot.n + 1)
    if behind.max(initial=0) > 1:
        said.append(
            f"not one arm but a tree of {robot.n} joints ({', '.join(robot.joint_names)}): wheels, "
            "a head or a second arm? --joints names those of the arm"
        )
    return robot, said


def _without_grippers(urdf: Path, robot: Robot) -> tuple[Robot, list[str]]:
    """Without the one joint of a gripper that moves by itself: it carries no other that does, and
    the far side of the gripper follows it."""
    root = urdf_root(urdf)
    names, kept, said = robot.joint_names, [*robot.joint_names], []
    for lead, parts in _led(root).items():
        carried = carried_by(root, lead)
        if lead not in names or carried & {*names} or carried >= {*parts} or len(kept) == 1:
            continue
        kept.remove(lead)
        said.append(
            f"{lead} left out, which {', '.join(parts)} follows (mimic): taken for a gripper, it "
            "is held where it is zero; --joints names others"
        )
    if said:
        robot = robot_from_urdf(urdf, kept, STANDARD_GRAVITY)
    return robot, said


def _follow(urdf: Path, robot: Robot) -> Iterator[str]:
    """Parts that move along with the arm, and are held still by every model of it."""
    for lead, parts in _led(urdf_root(urdf)).items():
        if lead in robot.joint_names:
            yield (
                f"{', '.join(parts)} follows {lead} (mimic): held where it is zero, so what it "
                "moves is missing in every model of this arm"
            )


def _led(root: ET.Element) -> dict[str, list[str]]:
    """Joints -> those that follow them."""
    found: dict[str, list[str]] = {}
    for part, lead in followers(root).items():
        found.setdefault(lead, []).append(part)
    return found


def _home(robot: Robot) -> Array | None:
    """Where zero meets the floor or a body: a pose that meets nothing, near to zero."""
    if _is_free(robot):
        return None
    around = Surroundings.of(robot)
    usual = around.limits.rest_pose()
    rng = np.random.default_rng(2)
    low, high = around.limits.lower, around.limits.upper
    drawn = rng.uniform(low, high, (TRIES, robot.n))
    turns = np.clip(np.round(drawn / (np.pi / 4)) * (np.pi / 4), low, high)
    turns[:, robot.prismatic] = usual[robot.prismatic]
    free = turns[around.allowed(turns)]
    if not len(free):
        return None
    pose = free[np.linalg.norm(free - usual, axis=1).argmin()]
    for j in range(robot.n):
        back = np.where(np.arange(robot.n) == j, usual, pose)
        pose = back if around.allowed(back[None])[0] else pose
    return np.asarray(pose)


def _is_free(robot: Robot) -> bool:
    """Where the arm rests if nobody says where."""
    around = Surroundings.of(robot)
    return bool(around.allowed(around.limits.rest_pose()[None])[0])


def _poses(robot: Robot) -> Array:
    rng = np.random.default_rng(1)
    low = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    high = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    return rng.uniform(low, high, (POSES, robot.n))


def _doubts(robot: Robot) -> Iterator[str]:
    mass = robot.parameters[:, 0]
    if not mass.any():
        yield (
            "the URDF has no inertias: recordings can be fitted, but gravity cannot be checked "
            "and a simulated arm weighs nothing"
        )
        return
    for j in np.flatnonzero(np.abs([robot.lower, robot.upper]).max(axis=0) > IN_DEGREES):
        if np.isfinite(robot.upper[j]) and not robot.prismatic[j]:
            yield (
                f"joint {j + 1} ({robot.joint_names[j]}) may turn from {robot.lower[j]:g} to "
                f"{robot.upper[j]:g} rad: a URDF's limits in degrees?"
            )
    carried = robot.carries() @ mass
    for j in np.flatnonzero(carried <= 0):
        yield f"joint {j + 1} ({robot.joint_names[j]}) carries no mass in the URDF"
    yield from _all_alike(robot)
    for j in np.flatnonzero(mass > 0):
        named = f"link behind joint {j + 1} ({robot.joint_names[j]})"
        own = _about_centre(robot.parameters[j])
        moments = np.linalg.eigvalsh(own)
        if np.allclose(own, np.eye(3), atol=1e-9):
            yield f"{named}: the inertia is 1 kg·m² about each axis, which looks like a placeholder"
        elif moments[0] < 0 or moments[2] > (1 + TRIANGLE) * (moments[0] + moments[1]):
            shown = ", ".join(f"{m:.3g}" for m in moments)
            yield f"{named}: no body has the principal moments {shown} kg·m²"


def _far_too_strong(robot: Robot, asked: Array) -> Iterator[str]:
    """A wrist may be many times as strong as it must be; an arm whose weakest joint could move it
    all a hundred times over is one of which nobody has stated that. asked: (n,) N·m (N)."""
    least, most = float(robot.effort.min()), float(asked.max())
    if most > 0 and np.isfinite(least) and least > STRONGEST * most:
        yield (
            f"each joint may give {least:g} N·m (N) or more by the URDF, where gravity and "
            f"{BRISK:g} rad/s² ask for {most:.2g} at most: a placeholder? State --torque: what is "
            "pushed with depends on it"
        )


def _all_alike(robot: Robot) -> Iterator[str]:
    """Links of one arm differ: where one carries another that is its like, and that a third,
    somebody filled in a form. Legs are each other's like."""
    heavy = robot.parameters[:, 0] > 0
    bodies = np.zeros((robot.n, 4))
    for j in np.flatnonzero(heavy):
        own = robot.parameters[j]
        bodies[j] = own[0], *np.linalg.eigvalsh(_about_centre(own))
    row = np.zeros(robot.n, dtype=int)
    for j in robot.order:
        above = robot.parent[j]
        like = above >= 0 and np.allclose(bodies[j], bodies[above], rtol=1e-6, atol=0.0)
        row[j] = heavy[j] * (1 + (row[above] if like else 0))
    if row.max() >= ALIKE:
        yield (
            f"{row.max()} links in a row have the same mass, {bodies[row.argmax(), 0]:g} kg, and "
            "the same inertia. Unless they are built alike these are placeholders: what the arm "
            "weighs, and every limit assumed from that, may be far off"
        )


def _about_centre(parameters: Array) -> Array:
    """(3, 3) kg·m² about the centre of mass, from PARAMETER_NAMES."""
    m, first = parameters[0], parameters[1:4]
    xx, xy, yy, xz, yz, zz = parameters[4:]
    about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    c = first / m
    return np.asarray(about - m * (c @ c * np.eye(3) - np.outer(c, c)))
