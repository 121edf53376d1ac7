"""The first motion of an arm: small, slow, and enough to tell what each joint is like."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pa10d.common.errors import UserError
from pa10d.dynamics.mass import mass_matrices
from pa10d.trajectory.kinds.base import Array, Kind
from pa10d.trajectory.kinds.strokes import RAMP_SHARE, stroke
from pa10d.trajectory.limits import TORQUE_SHARE
from pa10d.trajectory.motions import Drawing
from pa10d.trajectory.plan import Plan, Segment, joined
from pa10d.trajectory.poses import Surroundings

Part = Literal["friction", "sliding", "response", "poses"]
PARTS: tuple[Part, ...] = ("friction", "sliding", "response", "poses")

ALL_JOINTS = "all joints"  # the label of what tells friction
NUDGE = 0.04  # rad (m) to either side, less than any servo may be wrong by
LEAST_WAY = 0.01  # rad (m) of a joint that is to be measured: what moves by less counts as blocked
THERE, WAIT = 1.0, 3.0  # s to a place, and at it until a joint that sticks has come loose
SLOW, FAST = 0.15, 0.4  # of the speed limit
SLOW_MOST, FAST_MOST = 0.4, 0.7  # rad/s
LEAD, PERIOD = 0.2, 1.0  # s of small torques before the window that is looked at, and of that
RUN = 0.25  # s at the faster speed
SHORT = 0.055  # rad (m) to either side of the shortest strokes: a joint that hardly follows is no
# farther behind than their way
SHORT_RUN, TIMES = 0.02, 2  # s of them at speed, and how often to and fro
CALM = 0.7  # of the limits of speed and acceleration, on every way of an arm that is not known
POSES, REACH = 12, 0.4  # poses drawn for the heavy one, of the ranges
LIGHTER = 3.0  # times as light as its URDF says any body may be
NEAR_BY = 1.25  # times the gravity of a pose, that it may be about it
VARIES = 1.4  # a joint that is so much heavier in another pose is measured there, too


class FirstMotion(Kind):
    """Measures each joint: inertia, friction, delay, first resonance; the servo's gains follow.

    Each joint takes a small step alone, then all are pushed a little to and fro; where a servo is
    soft beside friction, its joint makes short quick strokes; then one after the other strokes
    slowly while small torques of many frequencies shake it. Skipped where the joints have been
    measured.
    """

    kind: ClassVar[str] = "first_motion"
    title: ClassVar[str] = "Measures every joint by small motions, and sets the gains from that"

    part: Part | None = Field(
        default=None,
        description="friction (all joints, seconds), sliding (one by one, short and quick, where a "
        "servo is soft beside friction), response (one by one), poses (one more pose for joints "
        "whose inertia depends on it); where absent all, sliding where it is needed",
    )
    again: bool = Field(default=False, description="also where the joints have been measured")
    speed: float = Field(
        default=1.0, ge=0.1, le=1.0, description="share of the usual speed of the strokes"
    )

    def build(self, around: Surroundings) -> Plan:
        """Segments named after their joint and what is seen in them."""
        calm = replace(
            around,
            limits=replace(
                around.limits,
                velocity=CALM * around.limits.velocity,
                acceleration=CALM * around.limits.acceleration,
            ),
        )
        home = self.home(calm)
        calm = _weighed_by_itself(calm, home)
        joints = self.chosen(calm)
        segments: list[Segment] = []
        if self.part in (None, "friction"):
            segments += self._nudges(calm, joints, home)
        if self.part == "sliding":
            segments += [one for j in joints for one in _short(calm, home, j, self.speed)]
        if self.part in (None, "response"):
            for j in joints:
                segments += _shaken(calm, home, j, self.speed)
                segments += _quick(calm, home, j, self.speed)
        if self.part in (None, "poses"):
            segments += self._elsewhere(calm, joints, home)
        return joined(self.kind, joints, segments, calm)

    def has_any(self, around: Surroundings) -> bool:
        """Whether this part has anything to do on this arm."""
        if self.part != "poses":
            return True
        around = _weighed_by_itself(around, self.home(around))
        return bool(self._elsewhere(around, self.chosen(around), self.home(around)))

    def _nudges(self, around: Surroundings, joints: list[int], home: Array) -> list[Segment]:
        """Each joint alone: whatever moves then, this one's torque has moved. Then all of them."""
        lower, upper = np.array(home), np.array(home)
        for j in joints:
            below, above = _way(around, home, j)
            lower[j], upper[j] = max(below, home[j] - NUDGE), min(above, home[j] + NUDGE)
        steps = Drawing(home)
        for j in joints:
            steps.to(np.where(np.arange(len(home)) == j, upper, steps.pose), THERE)
            steps.rest(THERE)
        steps.to(home, THERE)
        drawing = Drawing(home)
        for place in (upper, lower, upper, home):
            drawing.to(place, THERE)
            drawing.rest(WAIT)
        return [Segment(steps.knots(), "first steps"), Segment(drawing.knots(), ALL_JOINTS)]

    def _elsewhere(self, around: Surroundings, joints: list[int], home: Array) -> list[Segment]:
        """Empty where one pose is all there is."""
        if self.pose is not None:
            return []
        drawn = drawn_poses(replace(around, gravity_share=1.0 / TORQUE_SHARE), self.seed)
        here = _own_inertia(around, home)
        ratio = np.array([_own_inertia(around, pose) for pose in drawn]) / here
        varies = np.maximum(ratio, 1.0 / ratio) > VARIES
        return [
            part
            for pose, measured in zip(drawn, shared_out(varies[:, joints]), strict=True)
            for j in measured
            for part in _shaken(around, pose, joints[j], self.speed)
        ]


def _weighed_by_itself(around: Surroundings, home: Array) -> Surroundings:
    """Nobody has weighed the arm yet, and its URDF may be three times off: all that the motors can
    hold is tried. A joint that is as heavy falls no further than any that is not held. Where they
    cannot hold it as it stands, but could if it was as light, it is tried about there, too."""
    here = float(np.max(np.abs(around.gravity(home[None])[0]) / around.limits.torque))
    all_of_it = 1.0 / TORQUE_SHARE
    tried = here <= LIGHTER * all_of_it
    return replace(around, gravity_share=max(all_of_it, NEAR_BY * here) if tried else all_of_it)


def drawn_poses(around: Surroundings, seed: int) -> list[Array]:
    """(n,) each, some that are drawn; the one in which most joints carry much goes first."""
    rng = np.random.default_rng(seed)
    poses = [around.limits.rest_pose()]
    for _ in range(POSES):
        try:
            poses.append(around.random_pose(rng, REACH))
        except UserError:
            break
    inertia = np.diagonal(mass_matrices(around.robot, np.array(poses)), axis1=1, axis2=2)
    heavy = int(np.argmax(np.log(np.maximum(inertia, 1e-9)).sum(axis=1)))
    return [poses[heavy], *poses[:heavy], *poses[heavy + 1 :]]


def shared_out(varies: NDArray[np.bool_]) -> list[list[int]]:
    """For each of P poses the joints that are measured there; varies: (P, n), where each shows
    another inertia. All that show it in the first pose; the others in as few more as will do: what
    shows it nowhere is a rotor with a link that never counts, as far as these poses tell."""
    left, shared = varies.any(axis=0), [[] for _ in varies]
    at = 0
    while left.any():
        shared[at] = [int(j) for j in np.flatnonzero(varies[at] & left)]
        left &= ~varies[at]
        at = int(np.argmax((varies & left).sum(axis=1)))
    return shared


def shaken_joint(label: str) -> int | None:
    """The joint (0-based) that is shaken in a segment of this label."""
    name, _, what = label.rpartition(" ")
    return int(name.removeprefix("joint ")) - 1 if what == "shaken" else None


def _way(around: Surroundings, pose: Array, j: int) -> tuple[float, float]:
    """The free range of a joint about this pose; UserError where it has nowhere to go: no stroke is
    as short."""
    below, above = around.free_range(pose, j)
    if above - below < LEAST_WAY:
        raise UserError(
            f"joint {j + 1} has a way of {above - below:.2g} {around.robot.angle_unit(j)} about "
            f"the pose {np.round(pose, 3).tolist()}, expected {LEAST_WAY:g} at least: another "
            "pose, or the other joints alone (joints)"
        )
    return below, above


def _own_inertia(around: Surroundings, pose: Array) -> Array:
    """(n,) kg·m² with a trifle for the rotor, so that a ratio is one of numbers that count."""
    mass = np.diagonal(mass_matrices(around.robot, pose[None])[0])
    return np.asarray(mass + 0.1 * mass.max() * (around.limits.torque / around.limits.torque.max()))


def _short(around: Surroundings, pose: Array, j: int, share: float) -> list[Segment]:
    """As far as a nudge, as fast as its acceleration allows on that way: however little a servo may
    give beyond dry friction, no joint is farther behind than that."""
    below, above = _way(around, pose, j)
    lower, upper = max(below, pose[j] - SHORT), min(above, pose[j] + SHORT)
    speed = share * min(FAST * around.limits.velocity[j] / CALM, FAST_MOST)
    while (run := (upper - lower) / speed - _ramp(around, j, speed)) < SHORT_RUN:
        speed *= 0.9
    return TIMES * _to_and_fro(around, pose, j, lower, speed, run, "short")


def _shaken(around: Surroundings, pose: Array, j: int, share: float) -> list[Segment]:
    speed = share * min(SLOW * around.limits.velocity[j] / CALM, SLOW_MOST)
    travel = speed * (LEAD + PERIOD + _ramp(around, j, speed))
    lower, upper = _way(around, pose, j)
    if travel > upper - lower:
        speed, travel = speed * (upper - lower) / travel, upper - lower
    begin = float(np.clip(pose[j] - 0.5 * travel, lower, upper - travel))
    return _to_and_fro(around, pose, j, begin, speed, LEAD + PERIOD, "shaken")


def _quick(around: Surroundings, pose: Array, j: int, share: float) -> list[Segment]:
    """Over the way of the slow strokes, where they began."""
    slow = _shaken(around, pose, j, share)[0].motion
    begin, travel = slow.start[j], slow.end[j] - slow.start[j]
    speed = share * min(FAST * around.limits.velocity[j] / CALM, FAST_MOST)
    while (run := travel / speed - _ramp(around, j, speed)) < RUN:
        speed *= 0.9
    return _to_and_fro(around, pose, j, begin, speed, run, "quick")


def _ramp(around: Surroundings, j: int, speed: float) -> float:
    return float(max(1.5 * speed / (RAMP_SHARE * around.limits.acceleration[j]), 0.02))


def _to_and_fro(
    around: Surroundings, pose: Array, j: int, begin: float, speed: float, run: float, what: str
) -> list[Segment]:
    limit, label = around.limits.acceleration[j], f"joint {j + 1} {what}"
    end = begin + speed * (run + _ramp(around, j, speed))
    return [
        stroke(pose, j, begin, speed, run, limit, label),
        stroke(pose, j, end, -speed, run, limit, label),
    ]
