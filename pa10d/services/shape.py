"""What an arm looks like: its chain of joints, its bodies as the pre-check sees them, its meshes.

Called by the viewer, which remembers what it read.
"""

from __future__ import annotations

import base64
import logging
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.urdf_xml import urdf_root
from pa10d.dynamics import Robot
from pa10d.dynamics.environment import Box
from pa10d.figures.coarse import coarser
from pa10d.profile import load_profile
from pa10d.services.robots import load_robot
from pa10d.services.viewed import Shape, ShapeBox, ShapeCapsule, ShapeJoint, ShapeMesh
from pa10d.trajectory.capsules import capsules_of

Array = NDArray[np.float64]

MOST = 20_000  # triangles of one mesh: more is not seen, and slow over a slow link
LARGEST = 64 << 20  # bytes of a mesh file that is read at all

log = logging.getLogger("pa10d.shape")


@dataclass(frozen=True)
class LinkShape:
    """One mesh or plain solid on a link. link: 0-based joint that it moves with, -1: the base;
    place (4, 4): from its own coordinates to the joint's frame, m."""

    link: int
    place: Array
    vertices: Array
    triangles: NDArray[np.uint32]


def shape(data: str, profile: str) -> Shape:
    """The chain (as ``Robot`` has it), the capsules and the list of meshes, all in SI units.

    ``notes`` says which meshes the URDF names and nobody finds: the capsules stand for them.
    """
    robot = load_robot(profile)[1]
    bodies = capsules_of(robot)
    meshes, notes = _meshes(profile)
    return Shape(
        name=robot.name,
        joints=[_joint(robot, j) for j in range(robot.n)],
        order=robot.order.tolist(),
        up=_up(robot),
        floor=robot.environment.floor,
        boxes=[
            ShapeBox(box.name, box.size.tolist(), _placed(box).ravel().tolist())
            for box in robot.environment.boxes
        ],
        capsules=[
            ShapeCapsule(int(link), start.tolist(), end.tolist(), float(radius))
            for link, start, end, radius in zip(
                bodies.link, bodies.start, bodies.end, bodies.radius, strict=True
            )
            if np.any(start != end)  # what is asked of an end alone is part of another
        ],
        meshes=[ShapeMesh(b.link, b.place.ravel().tolist(), len(b.triangles)) for b in meshes],
        notes=list(notes),
    )


def _joint(robot: Robot, j: int) -> ShapeJoint:
    return ShapeJoint(
        name=robot.joint_names[j],
        parent=int(robot.parent[j]),
        rotation=robot.rotation[j].ravel().tolist(),
        translation=robot.translation[j].tolist(),
        axis=robot.axis[j].tolist(),
        prismatic=bool(robot.prismatic[j]),
        lower=_finite(robot.lower[j]),
        upper=_finite(robot.upper[j]),
    )


def mesh(data: str, profile: str, number: int) -> str:
    """One of the meshes, base64: counts of vertices and triangles (uint32), then the vertices
    (float32, x y z in m), then the triangles (uint32, three indices each); little-endian."""
    meshes = _meshes(profile)[0]
    if not 0 <= number < len(meshes):
        raise UserError(f"mesh {number}: expected a number from 0 to {len(meshes) - 1}")
    body = meshes[number]
    counts = np.array([len(body.vertices), len(body.triangles)], dtype="<u4")
    parts = (counts, body.vertices.astype("<f4"), body.triangles.astype("<u4"))
    return base64.b64encode(b"".join(part.tobytes() for part in parts)).decode()


@lru_cache(2)
def _meshes(profile: str) -> tuple[tuple[LinkShape, ...], tuple[str, ...]]:
    """Visual bodies of the URDF, and what could not be read."""
    found, robot = load_profile(profile), load_robot(profile)[1]
    root = urdf_root(found.urdf)
    notes = _forget_missing(root, found.urdf)
    if next(root.iter("visual"), None) is None:
        return (), tuple(notes)
    try:
        bodies = _visuals(ET.tostring(root, encoding="unicode"), robot, found.urdf)
    except (ValueError, RuntimeError) as error:
        log.warning("%s: %s", found.urdf, error)
        first = (str(error).strip().splitlines() or ["unreadable"])[0]
        return (), (*notes, f"the URDF's meshes cannot be read: {first}")
    return tuple(bodies), tuple(notes)


def _forget_missing(root: ET.Element, urdf: Path) -> list[str]:
    """Take out of the tree what cannot be shown; point the rest at files. → what is missing."""
    notes = []
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            solid = visual.find("geometry/mesh")
            if solid is None:
                continue
            named = solid.get("filename", "")
            file = _file(named, urdf)
            if file is None or file.stat().st_size > LARGEST:
                link.remove(visual)
                why = "is not there" if file is None else f"has more than {LARGEST >> 20} MB"
                notes.append(f"link {link.get('name')}: its mesh {named} {why}")
            else:
                solid.set("filename", str(file))
    return notes


def _file(named: str, urdf: Path) -> Path | None:
    """The file behind what a URDF says; ``package://NAME/…`` is looked for in the folders above."""
    plain = named.removeprefix("file://")
    if not named.startswith("package://"):
        path = Path(plain) if plain.startswith("/") else urdf.parent / plain
        return path if path.is_file() else None
    inside = named.removeprefix("package://")
    for folder in (urdf.parent, *urdf.parents[1:5]):
        for tried in (folder / inside, folder / inside.partition("/")[2]):
            if tried.is_file():
                return tried
    return None


def _visuals(urdf: str, robot: Robot, where: Path) -> list[LinkShape]:
    import pinocchio as pin

    model = pin.buildModelFromXML(urdf)
    solids = pin.buildGeomFromUrdfString(
        model, urdf, pin.GeometryType.VISUAL, package_dirs=str(where.parent)
    )
    names = robot.joint_names
    locked = [model.getJointId(name) for name in list(model.names)[1:] if name not in names]
    model, solids = pin.buildReducedModel(model, solids, locked, pin.neutral(model))
    out = []
    for one in solids.geometryObjects:
        above = int(one.parentJoint)
        link = names.index(model.names[above]) if above else -1
        faces = _faces(one.geometry)
        if faces is None:
            continue
        vertices, triangles = coarser(*faces, MOST)
        out.append(LinkShape(link, np.array(one.placement.homogeneous), vertices, triangles))
    return out


def _faces(geometry: Any) -> tuple[Array, NDArray[np.uint32]] | None:
    """Vertices (v, 3) and triangles (t, 3); None for what is no body of triangles."""
    import coal

    if isinstance(geometry, coal.Box):
        return _box(np.asarray(geometry.halfSide))
    if isinstance(geometry, coal.Cylinder):
        return _cylinder(float(geometry.radius), float(geometry.halfLength))
    if isinstance(geometry, coal.Sphere):
        return _sphere(float(geometry.radius))
    if not isinstance(geometry, coal.BVHModelBase):
        return None
    vertices = np.array(geometry.vertices(), dtype=float).reshape(-1, 3)
    count = int(geometry.num_tris)
    triangles = np.array(
        [[geometry.tri_indices(k)[i] for i in range(3)] for k in range(count)], dtype=np.uint32
    )
    return vertices, triangles.reshape(-1, 3)


def _box(half: Array) -> tuple[Array, NDArray[np.uint32]]:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    halves = [half for a, b, c, d in sides for half in ([a, b, c], [a, c, d])]
    return corners, np.array(halves, dtype=np.uint32)


def _cylinder(radius: float, half: float, around: int = 32) -> tuple[Array, NDArray[np.uint32]]:
    return _turned(np.array([[0, -half], [radius, -half], [radius, half], [0, half]]), around)


def _sphere(radius: float, around: int = 24) -> tuple[Array, NDArray[np.uint32]]:
    angle = np.linspace(-np.pi / 2, np.pi / 2, around // 2 + 1)
    return _turned(radius * np.column_stack([np.cos(angle), np.sin(angle)]), around)


def _turned(outline: Array, around: int) -> tuple[Array, NDArray[np.uint32]]:
    """A body of revolution about z from its outline (k, 2): distance from the axis, height."""
    angle = 2 * np.pi * np.arange(around) / around
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    vertices = np.concatenate([np.column_stack([r * ring, np.full(around, z)]) for r, z in outline])
    triangles = []
    for k in range(len(outline) - 1):
        for a in range(around):
            b = (a + 1) % around
            low, high = k * around, (k + 1) * around
            triangles += [[low + a, low + b, high + b], [low + a, high + b, high + a]]
    return vertices, np.array(triangles, dtype=np.uint32)


def _placed(box: Box) -> Array:
    """(4, 4) from the box's own axes, about its centre, to the base frame; m."""
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = box.rotation, box.position
    return place


def _up(robot: Robot) -> list[float]:
    """Against gravity, in the base frame; z where there is none."""
    size = float(np.linalg.norm(robot.gravity))
    return (-robot.gravity / size).tolist() if size > 0 else [0.0, 0.0, 1.0]


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
