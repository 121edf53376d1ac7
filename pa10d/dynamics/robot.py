"""The kinematic tree of a robot, read from its URDF by Pinocchio and kept as plain arrays."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.urdf_joints import carried_by, followers, movable_joints, tell_apart
from pa10d.common.urdf_xml import urdf_root
from pa10d.dynamics.environment import EMPTY, Box, Environment
from pa10d.dynamics.urdf_check import check_urdf

if TYPE_CHECKING:
    from pa10d.profile import Profile

Array = NDArray[np.float64]

XACRO = re.compile(r"\{[^}]*\bxacro/?\}|xacro:")
"""Of its elements: the address of the name space has changed over the years."""
IS_XACRO = "{0}: a xacro file; expected the URDF that 'xacro {0} > robot.urdf' makes"
STANDARD_GRAVITY = np.array([0.0, 0.0, -9.81])
USUAL_GAIN_ERROR = 0.05  # share of its value to which a torque constant is known unless stated
PARAMETER_NAMES = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""Standard inertial parameters of one link, in this order everywhere: mass (kg), first moments
(kg·m) and inertia about the origin of the joint's frame (kg·m²), as Pinocchio orders them."""


@dataclass(frozen=True)
class Robot:
    """A serial or tree-like arm with n one-degree-of-freedom joints; link j hangs on joint j.

    parent       (n,) index of the joint that carries joint j, -1 for the base
    order        (n,) indices such that parents come before children
    rotation     (n, 3, 3) orientation of joint j's frame at q_j = 0 in its parent's frame
    translation  (n, 3) m, its origin there
    axis         (n, 3) unit vector in joint j's frame
    prismatic    (n,) True where q_j is a length
    gravity      (3,) m/s² in the base frame
    parameters   (n, 10) standard parameters as the URDF has them, see PARAMETER_NAMES
    lower … acceleration  (n,) limits, rad, rad/s, N·m, rad/s²; inf where nothing is known
    gain_error   (n,) share of its value to which each drive's torque constant is known; None: USUAL
    home         (n,) rad (m) a pose that motions may begin at; None: zero, or mid-range
    environment  what stands around it
    """

    name: str
    joint_names: tuple[str, ...]
    parent: NDArray[np.int64]
    order: NDArray[np.int64]
    rotation: Array
    translation: Array
    axis: Array
    prismatic: NDArray[np.bool_]
    gravity: Array
    parameters: Array
    lower: Array
    upper: Array
    velocity: Array
    effort: Array
    acceleration: Array
    urdf: str
    gain_error: Array | None = None
    home: Array | None = None
    environment: Environment = EMPTY

    def gain_share(self, joints: Sequence[int]) -> float:
        """To what share of its value a torque is known: of these joints (0-based; empty: all), as
        a root mean square."""
        if self.gain_error is None:
            return USUAL_GAIN_ERROR
        own = self.gain_error[list(joints)] if len(joints) else self.gain_error
        return float(np.sqrt(np.mean(own**2)))

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joint_names)

    def torque_unit(self, joint: int) -> str:
        """What a joint's "torque" is measured in: a joint that slides has a force."""
        return "N" if self.prismatic[joint] else "N·m"

    def angle_unit(self, joint: int) -> str:
        """What a joint's position is measured in."""
        return "m" if self.prismatic[joint] else "rad"

    def torque_units(self) -> str:
        """Of all joints together, for the head of a column."""
        return " or ".join(sorted({self.torque_unit(j) for j in range(self.n)}))

    def with_gravity(self, gravity: Array) -> Robot:
        """The same arm under another gravity vector (3,) m/s², base frame."""
        return replace(self, gravity=np.asarray(gravity, dtype=float))

    def carries(self) -> NDArray[np.bool_]:
        """(n, n): True where joint i carries link j, so where link j can load joint i."""
        table = np.eye(self.n, dtype=bool)
        for j in self.order:
            if self.parent[j] >= 0:
                table[:, j] |= table[:, self.parent[j]]
        return table

    def pinocchio(self) -> Any:
        """A Pinocchio model of exactly these joints in this order is not always possible
        (Pinocchio sorts joints its own way), so: (model, index), with model's joint i being
        ours ``index[i]``."""
        model, names = _reduced_model(self.urdf, self.joint_names)
        model.gravity.linear = self.gravity
        return model, np.array([self.joint_names.index(name) for name in names])


def robot_from_urdf(
    urdf: str | Path,
    joints: list[str] | None = None,
    gravity: Array = STANDARD_GRAVITY,
    name: str | None = None,
) -> Robot:
    """Read a URDF (a path or the XML itself); meshes are never needed.

    joints: names of the movable joints in the wanted order; all others are locked at zero.
    Default: all that move by themselves, in the order of the file, or from base to tip.
    """
    text, where = _read(urdf)
    root = _parse(text, where)
    movable = movable_joints(root)
    chosen = list(joints) if joints is not None else movable
    for joint in chosen:
        if joint not in movable:
            raise UserError(
                f"{where}: joint {joint!r} is not a movable joint; "
                f"expected some of {', '.join(movable) or 'none (the URDF has no movable joint)'}"
            )
    if not chosen:
        raise UserError(f"{where}: no movable joint; expected revolute or prismatic joints")
    if len(set(chosen)) != len(chosen):
        raise UserError(f"{where}: joints: a name stands twice in {', '.join(chosen)}")
    _refuse_what_others_move(root, chosen, where)
    clean = _without_meshes(root)
    try:
        model, names = _reduced_model(clean, tuple(chosen))
    except (ValueError, RuntimeError) as error:
        first = str(error).strip().splitlines()[0] if str(error).strip() else "unreadable"
        raise UserError(f"{where}: not a usable URDF: {first}") from error
    return _from_model(model, names, chosen, clean, gravity, name or root.get("name") or "robot")


def robot_from_profile(profile: Profile) -> Robot:
    """The arm that a profile describes: mounting, tool and limits included."""
    gravity = STANDARD_GRAVITY if profile.gravity is None else np.array(profile.gravity)
    if profile.base is not None:
        gravity = _rpy(*profile.base.rpy).T @ STANDARD_GRAVITY
    robot = robot_from_urdf(profile.urdf, profile.joints, gravity, profile.name)
    limits = profile.limits

    def stated(key: str, values: list[float] | None, otherwise: Array) -> Array:
        return otherwise if values is None else _per_joint(profile, key, values, robot.n)

    limited = replace(
        robot,
        velocity=stated("velocity", limits.velocity, robot.velocity),
        effort=stated("torque", limits.torque, robot.effort),
        acceleration=stated("acceleration", limits.acceleration, robot.acceleration),
    )
    if limits.position is not None:
        lower, upper = _per_joint(profile, "position", limits.position, robot.n).T.copy()
        limited = replace(limited, lower=lower, upper=upper)
    arm = replace(
        limited,
        gain_error=_gain_error(profile, robot.n),
        home=_home(profile, robot.n),
        environment=_environment(profile),
        parameters=_with_tool(profile, robot.parameters),
    )
    _require_home_inside(profile, arm)
    return arm


def _require_home_inside(profile: Profile, robot: Robot) -> None:
    if robot.home is None:
        return
    for j in np.flatnonzero((robot.home < robot.lower) | (robot.home > robot.upper)):
        raise UserError(
            f"{profile.path}: home.{j + 1}: found {robot.home[j]:g}, expected a value within the "
            f"joint's limits, {robot.lower[j]:g} to {robot.upper[j]:g}"
        )


def _home(profile: Profile, n: int) -> Array | None:
    return None if profile.home is None else _per_joint(profile, "home", profile.home, n)


def _gain_error(profile: Profile, n: int) -> Array | None:
    given = profile.torque_gain_error
    if given is None:
        return None
    return np.array(given if isinstance(given, list) else [given] * n, dtype=float)


def _with_tool(profile: Profile, parameters: Array) -> Array:
    tool = profile.tool
    if tool is None:
        return parameters
    out = parameters.copy()
    out[-1] += rigid_body(tool.mass, tool.com, tool.inertia)
    return out


def _environment(profile: Profile) -> Environment:
    given = profile.environment
    boxes = [
        Box(box.name or f"box {k + 1}", np.array(box.size), np.array(box.xyz), _rpy(*box.rpy))
        for k, box in enumerate(given.boxes)
    ]
    return Environment(None if given.floor == "none" else given.floor, tuple(boxes))


def rigid_body(mass: float, com: Any, inertia: Any = (0.0,) * 6) -> Array:
    """Standard parameters (10,) of a body: mass kg, com (3,) m, inertia about com
    (Ixx Iyy Izz Ixy Ixz Iyz) kg·m², all in the frame of the link that holds it."""
    c = np.asarray(com, dtype=float)
    xx, yy, zz, xy, xz, yz = inertia
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    tensor = tensor + mass * (c @ c * np.eye(3) - np.outer(c, c))
    return np.array([mass, *(mass * c), *tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]])


def _per_joint(profile: Profile, key: str, values: Any, n: int) -> Array:
    if len(values) != n:
        place = key if key == "home" else f"limits.{key}"
        raise UserError(
            f"{profile.path}: {place}: found {len(values)} values, expected {n} (one a joint)"
        )
    return np.array(values, dtype=float)


def _read(urdf: str | Path) -> tuple[str | bytes, str]:
    """Bytes of a file: XML says itself how its letters are written."""
    if isinstance(urdf, str) and urdf.lstrip().startswith("<"):
        return urdf, "URDF"
    try:
        return Path(urdf).read_bytes(), str(urdf)
    except FileNotFoundError as error:
        raise UserError(f"{urdf}: no such file; expected a URDF") from error
    except OSError as error:
        raise UserError(f"{urdf}: {error.strerror}; expected a URDF, an XML text file") from error


def _parse(text: str | bytes, where: str) -> ET.Element:
    try:
        root = urdf_root(text)
    except ValueError as error:
        if "<xacro:" in (text if isinstance(text, str) else text.decode("latin-1")):
            raise UserError(IS_XACRO.format(where)) from error
        raise UserError(f"{where}: not well-formed XML: {error}; expected a URDF") from error
    if any(XACRO.match(str(element.tag)) for element in root.iter()):
        raise UserError(IS_XACRO.format(where))
    check_urdf(root, where)
    return root


def _refuse_what_others_move(root: ET.Element, chosen: Sequence[str], where: str) -> None:
    """Joints that follow others are held still, which is right for the far side of a gripper; not
    where they carry what is asked for: the arm's geometry would be another."""
    for name, lead in followers(root).items():
        beyond = [joint for joint in chosen if joint in carried_by(root, name)]
        if lead in chosen and beyond:
            raise UserError(
                f"{where}: joint {name!r} follows {lead!r} (mimic) and carries {beyond[0]!r}; "
                "expected an arm whose joints move by themselves: parallel linkages are not "
                "modelled"
            )


def _without_meshes(root: ET.Element) -> str:
    """Drop what dynamics does not need, and turn continuous joints into revolute ones, for
    which Pinocchio keeps one coordinate instead of a cosine and a sine."""
    tell_apart(root)
    for link in root.iter("link"):
        for tag in ("visual", "collision"):
            for element in link.findall(tag):
                link.remove(element)
    for joint in root.iter("joint"):
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
            limit = joint.find("limit")
            if limit is None:
                limit = ET.SubElement(joint, "limit", effort="0", velocity="0")
            limit.set("lower", "-1e9")
            limit.set("upper", "1e9")
    for tag in ("gazebo", "transmission", "material"):
        for element in root.findall(tag):
            root.remove(element)
    return ET.tostring(root, encoding="unicode")


def _reduced_model(urdf: str, joints: tuple[str, ...]) -> tuple[Any, list[str]]:
    import pinocchio as pin

    model = pin.buildModelFromXML(urdf)
    locked = [model.getJointId(name) for name in list(model.names)[1:] if name not in joints]
    model = pin.buildReducedModel(model, locked, pin.neutral(model))
    return model, list(model.names)[1:]


def _from_model(
    model: Any, names: list[str], chosen: list[str], urdf: str, gravity: Array, name: str
) -> Robot:
    import pinocchio as pin

    ours = [chosen.index(joint) for joint in names]  # Pinocchio's joint i is our ours[i]
    n = len(chosen)
    data = model.createData()
    q0 = pin.neutral(model)
    pin.computeJointJacobians(model, data, q0)
    parent = np.full(n, -1, dtype=np.int64)
    rotation, translation = np.empty((n, 3, 3)), np.empty((n, 3))
    axis, prismatic = np.empty((n, 3)), np.empty(n, dtype=bool)
    parameters = np.empty((n, 10))
    for i, j in enumerate(ours):
        placement = model.jointPlacements[i + 1]
        above = model.parents[i + 1]
        parent[j] = ours[above - 1] if above > 0 else -1
        rotation[j], translation[j] = placement.rotation, placement.translation
        jacobian = pin.getJointJacobian(model, data, i + 1, pin.ReferenceFrame.LOCAL)
        twist = jacobian.reshape(6, -1)[:, i]  # of a single joint Pinocchio returns a vector
        prismatic[j] = np.linalg.norm(twist[3:]) < 0.5
        axis[j] = twist[:3] if prismatic[j] else twist[3:]
        parameters[j] = model.inertias[i + 1].toDynamicParameters()
    inverse = np.argsort(ours)

    def limit(values: Any) -> Array:
        found = np.asarray(values, dtype=float)[inverse]
        return np.where(found > 0, found, np.inf)

    lower = np.asarray(model.lowerPositionLimit, dtype=float)[inverse]
    upper = np.asarray(model.upperPositionLimit, dtype=float)[inverse]
    unstated = (lower == 0.0) & (upper == 0.0)  # what a file means that leaves them out
    unlimited = unstated | (upper - lower > 1e8)
    return Robot(
        name=re.sub(r"\s+", "_", name),
        joint_names=tuple(chosen),
        parent=parent,
        order=np.array(ours, dtype=np.int64),
        rotation=rotation,
        translation=translation,
        axis=axis,
        prismatic=prismatic,
        gravity=np.asarray(gravity, dtype=float),
        parameters=parameters,
        lower=np.where(unlimited, -np.inf, lower),
        upper=np.where(unlimited, np.inf, upper),
        velocity=limit(model.velocityLimit),
        effort=limit(model.effortLimit),
        acceleration=np.full(n, np.inf),
        urdf=urdf,
    )


def _rpy(roll: float, pitch: float, yaw: float) -> Array:
    """Rotation of the base in the world, fixed axes x, y, z in turn (the URDF convention)."""
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (np.cos, np.sin))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
