"""What sizes of effects are measured by, and on which joints an effect can show.

Sizes are stated against the joint's own friction, load and speed, so they fit any arm. ``MARGIN``
times the white noise is the least torque that a draw chosen by strength adds at its strongest.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from backends.virtual.datasets.motions import Array, Reach
from backends.virtual.datasets.robot import open_robot, reach_of
from backends.virtual.plant.noise import white_level
from backends.virtual.plant.servo import feed_forward, inertia_at, nominal
from backends.virtual.plant.textbook import Textbook
from pa10d.common.jsonable import JsonObject
from pa10d.profile import Profile

Rng = np.random.Generator
MARGIN = 0.8


@dataclass(frozen=True)
class Figures:
    """What sizes are measured by, per joint (n,): see the names; load, slope: rms over poses of
    gravity torque, N·m, and of its derivative by the joint's own angle, N·m/rad; peak N·m of all
    torque in motion; inertia, lightest: median and least of the links alone, kg·m²; noise N·m."""

    reach: Reach
    book: Textbook
    load: Array
    slope: Array
    peak: Array
    inertia: Array
    lightest: Array
    noise: Array

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.load)


def figures_of(profile: str | os.PathLike[str] | Profile) -> Figures:
    """Measure a robot by its URDF and the default drives."""
    robot = open_robot(profile)
    reach = reach_of(robot)
    arm, book = nominal(robot)
    rng = np.random.default_rng(0)
    poses = reach.middle + 0.5 * reach.half * rng.uniform(-1, 1, (400, len(reach.half)))
    rest = np.zeros_like(poses)
    gravity = feed_forward(arm, book, poses, rest, rest)
    slope = np.empty_like(gravity)
    for j in range(poses.shape[1]):
        moved = poses.copy()
        moved[:, j] += 1e-4
        slope[:, j] = (feed_forward(arm, book, moved, rest, rest) - gravity)[:, j] / 1e-4
    each = np.array([inertia_at(arm, book, p) for p in poses[:50]]) - book.rotor_inertia
    rms = [np.sqrt(np.mean(x**2, axis=0)) for x in (gravity, slope)]
    noise = white_level(book.effort)
    peak = 1.2 * np.max(np.abs(gravity), axis=0) + book.coulomb + 0.7 * book.viscous * reach.speed
    return Figures(
        reach, book, rms[0], rms[1], peak, np.median(each, axis=0), np.min(each, axis=0), noise
    )


def sign(rng: Rng) -> float:
    return float(rng.choice([-1.0, 1.0]))


def any_joint(rng: Rng, f: Figures, strength: Array | None = None) -> int:
    """A joint (0-based) on which ``strength`` (n,), N·m, stands above the noise."""
    if strength is None:
        return int(rng.integers(f.n))
    fit = np.flatnonzero(strength >= MARGIN * f.noise)
    return int(rng.choice(fit)) if len(fit) else int(np.argmax(strength / f.noise))


def carrying(f: Figures) -> Array:
    """Load of the joints whose links outweigh their rotors; elsewhere 0."""
    return np.where(f.inertia > 0.5 * f.book.rotor_inertia, f.load, 0.0)


class NoPlace(ValueError):
    """An effect that no joint of the arm could show, and why."""


def heavy(f: Figures) -> NDArray[np.int64]:
    """Joints (0-based) that move enough behind their transmission for its give to matter."""
    found = np.flatnonzero(
        f.inertia > np.maximum(0.02 * np.max(f.inertia), 0.5 * f.book.rotor_inertia)
    )
    if not len(found):
        raise NoPlace("no joint of this arm moves links that are heavy beside its rotor")
    return found


def another(rng: Rng, f: Figures, joint: int) -> int:
    """A joint beside the given one, 0-based."""
    return int(rng.choice([k for k in range(_two(f)) if k != joint]))


def _two(f: Figures) -> int:
    if f.n < 2:
        raise NoPlace("it takes two joints")
    return f.n


def neighbours(rng: Rng, f: Figures, first: int = 0) -> tuple[int, int]:
    """Two adjacent joints of like size, 0-based, from the given one on."""
    alike = [
        i for i in range(first, _two(f) - 1) if 0.5 < f.book.effort[i] / f.book.effort[i + 1] < 2.0
    ]
    i = int(rng.choice(alike)) if alike else int(rng.integers(max(f.n - 1, 1)))
    return i, i + 1


Draw = Callable[[Rng, Figures], JsonObject]
