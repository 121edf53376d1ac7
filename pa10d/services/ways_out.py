"""What to do about a joint that swings or falls behind whatever gains a first motion sets; a change
of ``control`` is named only where it would let the joint be held otherwise."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from pa10d.common.jsonable import JsonObject
from pa10d.common.words import of_a_slide
from pa10d.control.faults import Fault
from pa10d.control.gains import after_swing, with_rotor
from pa10d.control.joint_figures import JointFigures, inertias
from pa10d.control.known_joints import KnownJoints
from pa10d.control.servo_design import SENSITIVITY
from pa10d.dynamics import Robot
from pa10d.profile import Profile
from pa10d.services.joints import (
    FASTER,
    FIRMER,
    SOFTEST,
    calmed,
    firmed,
    firmness,
    learnt,
    met_nothing,
    most_rate,
    pressed,
)
from pa10d.services.robots import load_robot

HELD = "look for what holds it, a brake or a collision"
MASSES = "correct the URDF's masses and inertias"
GEAR = "look at this joint's encoder, gear and coupling for play and springs"


def way_out(data: str, profile: str, known: JsonObject, fault: JsonObject) -> str:
    """See ``ways_out``, of what clients are told."""
    found = KnownJoints.from_document(known), Fault.from_document(fault)
    return ways_out(*load_robot(profile), *found)


def ways_out(profile: Profile, robot: Robot, known: KnownJoints, fault: Fault) -> str:
    """For a person; known: with the gains with which it happened last."""
    assert fault.axis is not None  # no arm swings or falls behind as a whole
    of = _of_a_swing if fault.kind == "oscillation" else _of_a_fall
    return of(profile, robot, known, fault, fault.axis)


def _of_a_fall(profile: Profile, robot: Robot, known: KnownJoints, fault: Fault, axis: int) -> str:
    if not met_nothing(profile, robot, known, fault):
        force = pressed(profile, robot, known, axis)
        said = of_a_slide(f"{force:.3g} N·m") if robot.prismatic[axis] else f"{force:.3g} N·m"
        if force >= robot.effort[axis]:
            return (
                f"all that it may give, the {said} of limits.torque, did not bring it there: "
                f"raise that if its motor is stronger, {HELD}, or {MASSES}"
            )
        return (
            f"its servo pressed on with {said}, more than friction that nobody knows of may "
            f"hold: {HELD}, or {MASSES}"
        )
    rest = f"{MASSES}, give first_motion a pose in which this joint hangs, or {HELD}"
    if firmed(profile, robot, known, fault) is not None:
        return f"firmer gains were set each time and did not do: {rest}"

    def firmer(other: Profile) -> bool:
        again = learnt(other, robot, known.figures)
        share = firmness(again.gains, axis) / firmness(known.gains, axis)
        return bool(np.isfinite(again.sensitivity[axis])) and share >= FIRMER

    doubted = known.figures.but(lighter=np.zeros(0))  # as light as any joint may be

    def with_margins(other: Profile) -> bool:
        peaks = learnt(other, robot, doubted).sensitivity
        return bool((peaks <= SENSITIVITY).all()) and firmer(other)

    change = _first_that(profile, with_margins) or _first_that(profile, firmer)
    if change is None:
        return f"its servo is as firm as it can be at any rate that this bus carries: {rest}"
    rate = f"{profile.control.rate:g} Hz"
    return f"its servo is as firm as it can be at {rate} without shaking it: {change}, {rest}"


def _of_a_swing(profile: Profile, robot: Robot, known: KnownJoints, fault: Fault, axis: int) -> str:
    if calmed(profile, robot, known, axis, fault.hertz) is not None:
        half = 0.5 * float(known.bandwidth[axis])
        softer = f"set control.bandwidth_hz to {half:.2g}, or {GEAR}"
        return f"calmer gains were set each time and did not end that: {softer}"
    explained = list(_explained(profile, robot, known, axis, fault.hertz))

    def calm(other: Profile) -> bool:
        held = (learnt(other, robot, one).sensitivity[axis] for one in explained)
        return any(np.isfinite(peak) for peak in held)

    change = _first_that(profile, calm)
    return f"calmer gains do not end that: {f'{change}, or ' if change else ''}{GEAR}"


def _explained(
    profile: Profile, robot: Robot, known: KnownJoints, axis: int, hertz: float
) -> Iterator[JointFigures]:
    """Joints that swing as this one did, at the rate at which it did."""
    figures = known.figures
    lighter = after_swing(robot, profile.control, figures, known.gains, axis, hertz)
    share = lighter.swung[axis] / inertias(robot, figures).usual[axis]
    if SOFTEST < share < 1.0 / SOFTEST:
        yield lighter
    sprung = with_rotor(robot, figures, axis, float(lighter.swung[axis]), hertz)
    if sprung is not None:
        yield sprung


def _first_that(profile: Profile, helps: Callable[[Profile], bool]) -> str | None:
    """The least change of ``control`` that does, in words: never a rate that no bus carries."""
    now, most = profile.control.rate, most_rate(profile)
    changes: list[tuple[dict[str, float | None], str]] = [
        ({"rate": r}, f"raise control.rate to {r:g} Hz") for r in FASTER if now < r <= most
    ]
    if profile.control.bandwidth_hz is not None:
        free: dict[str, float | None] = {"bandwidth_hz": None}
        out = "leave out control.bandwidth_hz"
        changes = [(free, out), *[(c | free, f"{words}, {out}") for c, words in changes]]
    for change, words in changes:
        control = profile.control.model_copy(update=change)
        if helps(profile.model_copy(update={"control": control})):
            return words
    return None
