"""The arm as capsules, for collisions with itself and with what stands around it.

A link is a straight capsule from its joint to each joint it carries (the last one: to where its
mass suggests that it ends). A weight that is carried is a capsule from the last joint to its
centre, as thick as a ball of iron. No mesh is read. The radius is that of a solid cylinder with the
link's smallest moment of inertia where that is believable, else a share of the length.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.dynamics.carried import CarryingRobot
from pa10d.trajectory.clearance import measure, origins

Array = NDArray[np.float64]

SHORT = 0.02  # m: offsets below this are no body of their own
RADIUS_SHARE = 0.15  # of a capsule's length, where the inertia is not believable
RADIUS_RANGE = (0.03, 0.12)  # m, of a guess by length
THICKEST, SLENDER = 0.15, 0.75  # m, and of its length, up to which an inertia is believed
SAME = 1e-4  # m: a drawing's angles are rounded, -3.141593 for half a turn
NEAR = 0.05  # m between two capsules that bend towards each other around a short piece


@dataclass(frozen=True)
class Capsules:
    """Segments fixed to links, and which of them may touch what.

    link (c,) the joint (0-based) each moves with, -1 for the base
    start, end (c, 3) m in that joint's frame (base frame for -1); radius (c,) m; the last ones, of
        no length, are ends of others that must stay above the floor by themselves
    pairs (p, 2) capsules that must not meet; grounded (f,) capsules that must stay above the floor
    blocked (b, 2) capsules and boxes of the robot's environment that must not meet
    """

    robot: Robot
    link: NDArray[np.int64]
    start: Array
    end: Array
    radius: Array
    pairs: NDArray[np.int64]
    grounded: NDArray[np.int64]
    blocked: NDArray[np.int64]

    def clearance(self, q: Array) -> Array:
        """(N, p + f + b) m between the surfaces of each pair, above the floor, from each box;
        < 0: inside."""
        r, around = self.robot, self.robot.environment
        out = np.empty((len(q), len(self.pairs) + len(self.grounded) + len(self.blocked)))
        boxes = np.zeros((len(around.boxes), 5, 3))
        for k, box in enumerate(around.boxes):
            boxes[k, 0], boxes[k, 1], boxes[k, 2:] = box.position, box.size / 2, box.rotation.T
        measure(
            np.ascontiguousarray(q, dtype=float), r.parent, r.order, r.rotation, r.translation,
            r.axis, r.prismatic, self.link, self.start, self.end, self.radius,
            self.pairs, self.grounded, around.floor or 0.0, self.blocked, boxes, out,
        )  # fmt: skip
        return out

    def hinge(self, q: Array, margin: float) -> tuple[float, Array]:
        """Σ max(0, margin - clearance)² and its gradient (N, n) in q."""
        short = np.maximum(margin - self.clearance(q), 0.0)
        grad = np.zeros_like(q)
        rows = np.flatnonzero(short.any(axis=1))
        if rows.size:
            step = 1e-6
            for j in range(q.shape[1]):
                moved = np.repeat(q[rows][None], 2, axis=0)
                moved[0, :, j] += step
                moved[1, :, j] -= step
                both = self.clearance(moved.reshape(-1, q.shape[1])).reshape(2, len(rows), -1)
                slope = (both[0] - both[1]) / (2 * step)
                grad[rows, j] = -2.0 * np.sum(short[rows] * slope, axis=1)
        return float(np.sum(short**2)), grad

    def name(self, column: int) -> str:
        """What a column of ``clearance`` is about."""
        if column < len(self.pairs):
            a, b = self.pairs[column]
            return f"{self._body(a)} and {self._body(b)}"
        column -= len(self.pairs)
        if column < len(self.grounded):
            return f"{self._body(self.grounded[column])} and the floor"
        capsule, box = self.blocked[column - len(self.grounded)]
        return f"{self._body(capsule)} and '{self.robot.environment.boxes[box].name}'"

    def _body(self, capsule: int) -> str:
        link = int(self.link[capsule])
        return "the base" if link < 0 else f"link {link + 1}"


def capsules_of(robot: Robot) -> Capsules:
    """Capsules of an arm, and what of them may meet what."""
    link, start, end, radius = [], [], [], []
    bare = robot.bare if isinstance(robot, CarryingRobot) and robot.bare is not None else robot
    for body in (-1, *range(robot.n)):
        for tip in _tips(bare, body):
            if np.linalg.norm(tip) >= SHORT:
                link.append(body)
                start.append(np.zeros(3))
                end.append(tip)
                radius.append(_radius(bare, body, tip))
    if isinstance(robot, CarryingRobot) and robot.centre is not None:
        link.append(robot.n - 1)
        start.append(np.zeros(3))
        end.append(robot.centre)
        radius.append(robot.radius)
    table = np.array(link, dtype=np.int64)
    shape = (len(link), 3)
    bodies = Capsules(
        robot,
        table,
        np.array(start).reshape(shape),
        np.array(end).reshape(shape),
        np.array(radius, dtype=float),
        np.zeros((0, 2), dtype=np.int64),
        np.zeros(0, dtype=np.int64),
        np.zeros((0, 2), dtype=np.int64),
    )
    apart = [
        (a, b)
        for a in range(len(link))
        for b in range(a + 1, len(link))
        if not _neighbours(bodies, a, b)
    ]
    around, count = robot.environment, range(len(link))
    blocked = [(c, k) for k in range(len(around.boxes)) for c in count if _moves(bodies, c, k)]
    return replace(
        bodies if around.floor is None else _above_the_floor(bodies),
        pairs=np.array(apart, dtype=np.int64).reshape(-1, 2),
        blocked=np.array(blocked, dtype=np.int64).reshape(-1, 2),
    )


def _above_the_floor(bodies: Capsules) -> Capsules:
    """With those that must stay above it: of one that hangs on a joint of constant height its far
    end, a ball. As near as that joint is to the floor it was built, and no pose would be free."""
    far = np.flatnonzero([not _moves_about(bodies.robot, j, slice(2, 3)) for j in bodies.link])
    spheres = np.arange(len(far)) + len(bodies.link)
    split = replace(
        bodies,
        link=np.r_[bodies.link, bodies.link[far]],
        start=np.r_[bodies.start, bodies.end[far]],
        end=np.r_[bodies.end, bodies.end[far]],
        radius=np.r_[bodies.radius, bodies.radius[far]],
    )
    whole = np.setdiff1d(np.arange(len(bodies.link)), far)
    moving = [int(c) for c in (*whole, *spheres) if _moves(split, int(c))]
    return replace(split, grounded=np.array(moving, dtype=np.int64))


def _tips(robot: Robot, body: int) -> list[Array]:
    """Ends of a link in its own frame: the origins of the joints that it carries."""
    carried = [robot.translation[j] for j in range(robot.n) if robot.parent[j] == body]
    if carried or body < 0:
        return carried
    mass = robot.parameters[body, 0]
    return [2.0 * robot.parameters[body, 1:4] / mass] if mass > 0 else []


def _radius(robot: Robot, body: int, tip: Array) -> float:
    """½·m·r² is a cylinder's inertia about its own axis: the smallest of the three."""
    fallback = float(np.clip(RADIUS_SHARE * np.linalg.norm(tip), *RADIUS_RANGE))
    if body < 0 or robot.parameters[body, 0] <= 0:
        return fallback
    m, c = robot.parameters[body, 0], robot.parameters[body, 1:4] / robot.parameters[body, 0]
    xx, xy, yy, xz, yz, zz = robot.parameters[body, 4:]
    about_origin = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    smallest = np.linalg.eigvalsh(about_origin - m * (c @ c * np.eye(3) - np.outer(c, c)))[0]
    radius = float(np.sqrt(max(2.0 * smallest / m, 0.0)))
    thickest = min(THICKEST, SLENDER * float(np.linalg.norm(tip)))
    return radius if RADIUS_RANGE[0] <= radius <= thickest else fallback


def _neighbours(bodies: Capsules, a: int, b: int) -> bool:
    """Capsules so near along the chain that they touch in every pose: nothing, or a piece shorter
    than their radii, lies between them."""
    robot, links = bodies.robot, (int(bodies.link[a]), int(bodies.link[b]))
    up, down = _chain(robot, links[0]), _chain(robot, links[1])
    shared = set(up) & set(down)
    between = [j for j in (*up, *down) if j not in shared]
    if links[0] in (*down, -1) or links[1] in (*up, -1):
        between = between[:-1]  # the joint at the end of the upper capsule starts no gap
    gap = sum(float(np.linalg.norm(robot.translation[j])) for j in between)
    return gap < max(SHORT, bodies.radius[a] + bodies.radius[b] + NEAR)


def _chain(robot: Robot, link: int) -> list[int]:
    """A link and what carries it, outermost first."""
    chain = []
    while link >= 0:
        chain.append(link)
        link = int(robot.parent[link])
    return chain


def _moves(bodies: Capsules, capsule: int, box: int | None = None) -> bool:
    """Whether a capsule's distance from a box (None: from the floor) depends on the pose at all:
    what the arm stands on, it always touches. One that is never out of a box counts where its own
    joint is moved about in there: that is no stand, but something in its way."""
    q = _any_poses(bodies.robot)
    if box is None:
        only = replace(bodies, grounded=np.array([capsule], dtype=np.int64))
    else:
        only = replace(bodies, blocked=np.array([[capsule, box]], dtype=np.int64))
    distance = only.clearance(q)[:, 0]
    if distance.max() - distance.min() > SAME:
        return True
    never_out = box is not None and distance.max() < SAME - bodies.radius[capsule]
    return never_out and _moves_about(bodies.robot, int(bodies.link[capsule]))


def _any_poses(robot: Robot) -> Array:
    return np.random.default_rng(0).uniform(-np.pi, np.pi, (12, robot.n))


def _moves_about(robot: Robot, link: int, along: slice = slice(3)) -> bool:
    """Whether the joint of a link stands elsewhere in other poses. along: axes of the base."""
    if link < 0:
        return False
    q = _any_poses(robot)
    places = np.empty((*q.shape, 3))
    origins(
        q, robot.parent, robot.order, robot.rotation, robot.translation, robot.axis,
        robot.prismatic, places,
    )  # fmt: skip
    return bool(np.ptp(places[:, link, along], axis=0).max() > SAME)
