"""From one pose to another without meeting anything: straight where that is possible, else by two
trees that grow towards each other (RRT-Connect, Kuffner & LaValle 2000), then shortened."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.trajectory.poses import CLEAR, Surroundings

Array = NDArray[np.float64]

NEAR = 1e-9  # rad: nothing to move
REACH = 1.5  # rad (largest joint) by which a tree grows at once
GROWTHS = 3000
STRAY = np.pi  # rad that a way may lead beyond either end or the rest pose
OUTSIDE = 0.02  # rad beyond a limit that a stop may have ended at
CUTS = 60  # tries to leave out poses in between


def way_is_free(around: Surroundings, here: Array, there: Array) -> bool:
    """Whether bodies keep apart on the straight way."""
    return around.free_share(here, there) == 1.0


def free_way(around: Surroundings, here: Array, there: Array, seed: int = 0) -> list[Array]:
    """Poses to go to one after the other, straight between them, the last one ``there``; empty
    where nothing is to be done."""
    if np.abs(there - here).max() <= NEAR:
        return []
    if way_is_free(around, here, there):
        return [there]
    for pose in (here, there):
        _require_inside(around, pose)
        if not way_is_free(around, pose, pose):
            raise UserError(
                f"the pose {np.round(pose, 3).tolist()} rad has bodies nearer than {CLEAR:g} m to "
                f"each other or to {around.robot.environment}: no way leads there; expected "
                "another pose"
            )
    home = around.limits.rest_pose()
    if way_is_free(around, here, home) and way_is_free(around, home, there):
        return [home, there]
    rng = np.random.default_rng(seed)
    return _shortened(around, _connected(around, here, there, rng), rng)[1:]


def _require_inside(around: Surroundings, pose: Array) -> None:
    low, high = around.limits.lower, around.limits.upper
    for j in np.flatnonzero((pose < low - OUTSIDE) | (pose > high + OUTSIDE)):
        raise UserError(
            f"joint {j + 1} at {pose[j]:.4f} rad is outside of its limits, {low[j]:.4f} to "
            f"{high[j]:.4f}: no way leads there; move it inside by hand, or correct its zero_offset"
        )


class _Tree:
    def __init__(self, root: Array) -> None:
        self.poses, self.parent = [root], [-1]

    def grow(self, around: Surroundings, towards: Array) -> tuple[Array, bool]:
        """From the nearest pose as far as is free: the pose that was reached, and whether it is
        new."""
        distance = np.abs(np.array(self.poses) - towards).max(axis=1)
        nearest = int(np.argmin(distance))
        here = self.poses[nearest]
        goal = here + (towards - here) * min(1.0, REACH / max(distance[nearest], 1e-12))
        share = around.free_share(here, goal)
        if share == 0.0:
            return here, False
        self.poses.append(here + share * (goal - here))
        self.parent.append(nearest)
        return self.poses[-1], True

    def back(self, pose: Array) -> list[Array]:
        """The branch from the root to a pose of the tree."""
        k = next(i for i, p in enumerate(self.poses) if p is pose)
        way = []
        while k >= 0:
            way.append(self.poses[k])
            k = self.parent[k]
        return way[::-1]


def _connected(
    around: Surroundings, here: Array, there: Array, rng: np.random.Generator
) -> list[Array]:
    ends = np.array([here, there, around.limits.rest_pose()])
    lower = np.maximum(around.limits.lower, ends.min(axis=0) - STRAY)
    upper = np.minimum(around.limits.upper, ends.max(axis=0) + STRAY)
    one, other = _Tree(here), _Tree(there)
    for turn in range(GROWTHS):
        reached, new = one.grow(around, rng.uniform(lower, upper))
        while new:
            met, new = other.grow(around, reached)
            if np.abs(met - reached).max() <= NEAR:
                first, second = one.back(reached), other.back(met)
                if turn % 2:
                    first, second = second, first
                return [*first, *second[-2::-1]]
        one, other = other, one
    raise UserError(
        f"no way found from {np.round(here, 2).tolist()} to {np.round(there, 2).tolist()} rad that "
        f"keeps clear of the arm itself and {around.robot.environment}; expected poses nearer to "
        "each other"
    )


def _shortened(around: Surroundings, way: list[Array], rng: np.random.Generator) -> list[Array]:
    for _ in range(CUTS):
        if len(way) < 3:
            break
        i, j = np.sort(rng.choice(len(way), 2, replace=False))
        if j - i > 1 and way_is_free(around, way[i], way[j]):
            way = [*way[: i + 1], *way[j:]]
    return way
