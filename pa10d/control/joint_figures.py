"""What is known of each joint: presumed from the URDF and the drive's size, or measured."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.dynamics import Robot
from pa10d.dynamics.mass import mass_matrices

Array = NDArray[np.float64]

POSES = 256
STROKE, ON_THE_WAY = 0.35, 8  # rad to either side, in a first motion; poses on a way
ABOVE_LIGHTEST = 1.5  # leaves 4 dB until the loop's delay of 4 ms makes it unstable
ROTOR = 0.75 / 232.0**1.75  # kg·m² per N·m^1.75: PA10's first axes, scaled by the torque limit
BETWEEN = 3.0  # times that: in the middle of the PA10's, 1, and the PUMA 560's, 4 to 17
DRAWS = 4  # of bodies as they may be as well, beside the likeliest
ROUGH, MEASURED = 3.0, 1.25  # by which an inertia may be wrong: a URDF's, a measured one


class Inertias(NamedTuple):
    """(n,) each, kg·m²: in the lightest pose with all other joints giving way; what gains are made
    for; in the heaviest pose with all others held."""

    light: Array
    usual: Array
    heavy: Array


@dataclass(frozen=True)
class JointFigures:
    """(n,) each.

    rotor      kg·m² that is there in every pose
    link       by which the URDF's own inertia about the joint is multiplied, in any pose
    coulomb    N·m
    viscous    N·m·s/rad
    delay      s from torque to motion beyond what the loop itself takes; may be a little less
    stiffness  N·m/rad of a spring between motor and link, inf: none was seen
    motor      kg·m² on the motor's side of that spring
    doubt      factor by which the inertia may be wrong, to either side
    swung      kg·m² of a free joint that would swing as this one did with too high gains, 0: never
    bodies     (1 + DRAWS, n, 10) standard parameters as they were felt, and as they may be as well;
               empty: the URDF's own
    lighter    factor by which the inertia may be smaller; empty: as ``doubt`` says
    about      (P, n) rad, poses that the arm may come to while this is all that is known; empty:
               anywhere within its limits
    """

    rotor: Array
    link: Array
    coulomb: Array
    viscous: Array
    delay: Array
    stiffness: Array
    motor: Array
    doubt: Array
    swung: Array
    bodies: Array = field(default_factory=lambda: np.zeros((0, 0, 10)))
    lighter: Array = field(default_factory=lambda: np.zeros(0))
    about: Array = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def least(self) -> Array:
        """(n,) factor by which the inertia may be smaller."""
        return self.lighter if len(self.lighter) else self.doubt

    def resonance(self, inertia: Array) -> Array:
        """(n,) Hz at which motor and link swing against each other, inf: never."""
        sprung = np.isfinite(self.stiffness)
        with np.errstate(all="ignore"):
            rest = 1.0 / self.motor + 1.0 / np.maximum(inertia - self.motor, 1e-9)
            swing = np.sqrt(self.stiffness * rest) / (2 * np.pi)
        return np.where(sprung, swing, np.inf)

    def document(self) -> JsonObject:
        """For JSON; null for what is infinite."""
        own = {
            key: [float(v) if np.isfinite(v) else None for v in getattr(self, key)]
            for key in PER_JOINT
        }
        return own | {key: getattr(self, key).tolist() for key in WHOLE}

    @staticmethod
    def from_document(document: Mapping[str, Any]) -> JointFigures:
        """The other way; ValueError where it is none."""
        arrays = {
            k: np.array([np.inf if v is None else float(v) for v in document[k]]) for k in PER_JOINT
        }
        bodies = np.array(document["bodies"], dtype=float).reshape(-1, len(arrays["link"]), 10)
        about = np.array(document.get("about", []), dtype=float).reshape(-1, len(arrays["link"]))
        lighter = np.array(document.get("lighter", []), dtype=float)
        sizes = {len(v) for v in arrays.values()} | ({len(lighter)} if len(lighter) else set())
        sound = all((v >= 0).all() for k, v in arrays.items() if k != "delay")  # no number is not
        sound = sound and bool(np.isfinite(arrays["delay"]).all())
        if (
            len(sizes) != 1
            or not sound
            or not all(np.isfinite(v).all() for v in (bodies, lighter, about))
        ):
            raise ValueError("expected as many figures of 0 or more for each joint")
        return JointFigures(**arrays, bodies=bodies, lighter=lighter, about=about)

    def but(self, **values: Array) -> JointFigures:
        """With other values."""
        return replace(self, **values)

    def after(self, before: JointFigures) -> JointFigures:
        """With the swings seen before these were measured; where a spring was found since, the
        rotor in front of it is what swung, and no free joint as light as that. What fell behind
        stays as heavy as that showed it to be, until its inertia is measured: the factor is one of
        what was presumed."""
        swung = np.where(np.isfinite(self.stiffness), self.swung, before.swung)
        presumed = (self.rotor == before.rotor) & (self.link == before.link)
        fallen = before.least if len(before.lighter) else self.doubt
        lighter = np.where(presumed, np.minimum(self.doubt, fallen), self.doubt)
        return self.but(swung=swung, lighter=lighter)


WHOLE = ("bodies", "lighter", "about")  # fields that may be empty
PER_JOINT = tuple(name for name in JointFigures.__dataclass_fields__ if name not in WHOLE)


def presumed_figures(robot: Robot) -> JointFigures:
    """Nobody has measured anything: the URDF's bodies, a rotor of usual size, no friction."""
    zero, one = np.zeros(robot.n), np.ones(robot.n)
    rotor = ROTOR * np.where(np.isfinite(robot.effort), robot.effort, 0.0) ** 1.75
    rigid, bodies = np.full(robot.n, np.inf), robot.parameters[None].copy()
    return JointFigures(rotor, one, zero, zero, zero, rigid, zero, ROUGH * one, zero, bodies)


def likely_figures(robot: Robot) -> JointFigures:
    """The same with rotors as real arms have them, to either side of which there is doubt. What is
    not made with margins for it takes the lightest that there are: as presumed."""
    presumed = presumed_figures(robot)
    return presumed.but(rotor=BETWEEN * presumed.rotor)


def first_figures(robot: Robot, places: Sequence[Any]) -> JointFigures:
    """Likely, of an arm that goes from one of these places (K, n) rad to the next, and about each
    strokes one joint after the other."""
    stops = np.array(places, dtype=float)
    share = np.linspace(0.0, 1.0, ON_THE_WAY)[:, None]
    ways = [a + share * (b - a) for a, b in itertools.pairwise(stops)]
    apart = STROKE * np.concatenate([np.eye(robot.n), -np.eye(robot.n)])
    strokes = (stops[:, None] + apart).reshape(-1, robot.n)
    within = np.clip(strokes, robot.lower, robot.upper)
    return likely_figures(robot).but(about=np.concatenate([stops, *ways, within]))


def inertias(robot: Robot, figures: JointFigures) -> Inertias:
    """Over poses drawn within the limits. A joint that is ``ROUGH`` times heavier than usual counts
    so only in poses that the arm may come to; it is as light as anywhere, and as heavy up to that:
    firm gains shake springs that nobody has seen.

    What gains are made for is the median, but at most ``ABOVE_LIGHTEST`` times the lightest: on
    the PA10 the third joint of a stretched arm moves a quarter of its median, and swings up at
    47 Hz if its gains are made for that.
    """
    poses = drawn_poses(robot)
    if len(figures.about):
        poses = np.concatenate([figures.about, poses])
    mass = whole_masses(robot, figures, poses)
    own = np.diagonal(mass, axis1=1, axis2=2)
    light = np.min(1.0 / np.diagonal(np.linalg.inv(mass), axis1=1, axis2=2), axis=0)
    usual = np.minimum(np.median(own, axis=0), ABOVE_LIGHTEST * light)
    heavy = own.max(axis=0)
    if len(figures.about):
        near = own[: len(figures.about)].max(axis=0)
        heavy = np.maximum(near, np.minimum(heavy, ROUGH * usual))
    return Inertias(light, usual, heavy)


def inertias_alone(robot: Robot, figures: JointFigures) -> Array:
    """(n,) kg·m² with all others held, in the median of the same poses."""
    mass = whole_masses(robot, figures, drawn_poses(robot))
    return np.asarray(np.median(np.diagonal(mass, axis1=1, axis2=2), axis=0))


def whole_masses(robot: Robot, figures: JointFigures, poses: Array) -> Array:
    """(P, n, n) kg·m² of links and rotors as they are known, in poses (P, n) rad."""
    scale = np.sqrt(figures.link)
    bodies = mass_matrices(robot, poses)
    return np.asarray(bodies * scale[:, None] * scale + np.diag(figures.rotor))


def poses_of(robot: Robot, figures: JointFigures) -> Array:
    """(P, n) rad that the arm may come to."""
    return figures.about if len(figures.about) else drawn_poses(robot)


def drawn_poses(robot: Robot) -> Array:
    """(POSES, n) rad within the limits."""
    rng = np.random.default_rng(0)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    return rng.uniform(lower, upper, (POSES, robot.n))
