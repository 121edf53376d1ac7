"""What speaks against a finding besides its rivals: said at the end of its sentence.

What is left on its joint, what it leaves on others, a geometry that would do as well, a curve that
it may be a part of, or its own numbers.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pa10d.common.words import listed, times
from pa10d.diagnose.constants import (
    BEYOND_SLOW_NOISE,
    LEVEL,
    SHARE_FAR,
    SHARE_OFF,
    STANDS_BESIDE_MORE,
    STANDS_IN,
)
from pa10d.diagnose.evidence.curves import angles_of, parts_of_curves
from pa10d.diagnose.outcome.diagnosis import Finding
from pa10d.diagnose.outcome.words import helped_most
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.claims import Unexplained
from pa10d.diagnose.unknown.geometry import Geometry
from pa10d.diagnose.unknown.remaining import Remaining
from pa10d.diagnose.unknown.structure import Structure
from pa10d.dynamics import Robot

ONE_CURVE = (
    " It may be no more than a part of one curve over joint {joint}'s angle (a cam, a "
    "compensator): of what is named there, seen over so few turns, any curve can be put together."
)
ONE_FORCE = (
    " Joint {other} keeps what depends on {on}: a force between the links (a spring, a magnet, a "
    "hose) pulls at both joints, and this may be its share here."
)

OTHER_SPRING = (
    " Its share of the joint's torque comes out at {share}, and through a spring in the gear all "
    "of it passes (1): a frame that gives, or another joint's spring, may be behind it."
)
OR_BASE = (
    " A base that has turned about this joint's axis, by as much the other way, would look the "
    "same: look at both."
)
NOT_WHOLE = (
    " Its share of the joint's torque comes out at {share} and not at 1: the law is not followed "
    "in full, and its other numbers are known no better than that."
)


def with_doubts(
    findings: Sequence[Finding],
    state: SearchState,
    given: int,
    lines: Sequence[Remaining],
    unexplained: Sequence[Unexplained],
    geometry: Geometry,
) -> tuple[Finding, ...]:
    """Findings as they are to be read. given: terms that the model had before; lines, unexplained:
    what is left after all of them; geometry: lengths and axes that would do as well."""
    doubted = [
        _or_one_force(one if curve else _beside_more(one, lines), unexplained)
        for one, curve in _of_curves(state, given, findings)
    ]
    return tuple(_or_base(_or_geometry(one, geometry), state.model.robot) for one in doubted)


def _or_base(finding: Finding, robot: Robot) -> Finding:
    """A zero of a first joint that gravity loads is the base's own angle about that axis."""
    if not finding.term.effect.turns_joint:
        return finding
    (joint,) = finding.term.joints
    axis = robot.rotation[joint] @ robot.axis[joint]
    level = np.linalg.norm(np.cross(axis, robot.gravity)) > LEVEL * np.linalg.norm(robot.gravity)
    if robot.parent[joint] >= 0 or robot.prismatic[joint] or not level:
        return finding
    return replace(finding, sentence=finding.sentence + OR_BASE)


def _or_one_force(finding: Finding, unexplained: Sequence[Unexplained]) -> Finding:
    """What stores energy by two angles pulls at both of their joints: where a map of the two is
    left on one, a law of the other's angle may be the same thing, seen from there."""
    if not finding.term.effect.follows_angle:
        return finding
    own = finding.term.joints
    for one in unexplained:
        if not isinstance(one, Structure) or one.joint in own:
            continue
        if set(one.variables) in [{f"q{j + 1}", f"q{one.joint + 1}"} for j in own]:
            text = ONE_FORCE.format(other=one.joint + 1, on=listed(one.variables))
            return replace(finding, sentence=finding.sentence + text)
    return finding


def _or_geometry(finding: Finding, geometry: Geometry) -> Finding:
    """With what would do as well as the finding."""
    if (finding.term.effect_id, finding.term.joints) not in geometry.as_well:
        return finding
    text = f" An arm that is not as its URDF says would do as well: {geometry.words}."
    return replace(finding, sentence=finding.sentence + text)


def _of_curves(
    state: SearchState, given: int, findings: Sequence[Finding]
) -> Iterator[tuple[Finding, bool]]:
    """With that doubt, and whether they have it, those that may be parts of one curve."""
    found = list(enumerate(state.terms))[given:]
    parts = parts_of_curves(found, angles_of(state))
    for index, finding in enumerate(findings, given):
        joint = next((j for j, own in parts.items() if index in own), None)
        text = "" if joint is None else ONE_CURVE.format(joint=joint + 1)
        yield replace(finding, sentence=finding.sentence + text), joint is not None


def _beside_more(finding: Finding, lines: Sequence[Remaining]) -> Finding:
    """What is named on a joint whose error follows something unnamed, too, may be part of that; so
    may a law that moves another torque than its own shape says, one that takes less than it leaves,
    and one that leaves more than slow noise reaches."""
    j = helped_most(finding.term, finding.rms_before, finding.rms_after)[0]
    told = lines[j].significant or not _whole(finding)
    beside = lines[j].ratio > (STANDS_IN if told else BEYOND_SLOW_NOISE)
    if not (beside or _leaves_more(finding, lines[j])):
        return replace(finding, sentence=finding.sentence + _of_its_share(finding))
    text = (
        f" Joint {j + 1} still keeps {times(lines[j].ratio)} its noise floor: this may stand in "
        "for what is missing there."
    )
    return replace(finding, sentence=finding.sentence + text + _of_its_share(finding))


def _of_its_share(finding: Finding) -> str:
    """What a law's own torque says against it, where its shape alone should settle how much there
    is: all of a joint's torque passes through a spring in its gear, or through its play, whatever
    the noise. A frame that gives under the arm asks for something like a spring."""
    wholes = [c for c in finding.term.effect.coefficients if c.whole_at_one]
    for kind in wholes:
        told = finding.parameters.get(kind.name)
        if told is None or not abs(told.value - 1.0) > SHARE_OFF * told.std_error_random > 0.0:
            continue
        least, most = max(kind.lower, 1.0 - SHARE_FAR), min(kind.upper, 1.0 + SHARE_FAR)
        if not least <= told.value <= most:
            text = OTHER_SPRING if finding.term.effect.series_spring else NOT_WHOLE
            return text.format(share=f"{told.value:.2g} ± {told.std_error_random:.1g}")
    return ""


def _leaves_more(finding: Finding, line: Remaining) -> bool:
    """Is what remains of a joint material, and, its noise aside, more than the finding took?"""
    took = finding.rms_before[line.joint] ** 2 - finding.rms_after[line.joint] ** 2
    return line.ratio > STANDS_BESIDE_MORE and bool(line.rms**2 - line.floor**2 > took)


def _whole(finding: Finding) -> bool:
    """Are coefficients that a shape alone should settle what they can be, and within their own
    doubt what they should be?"""
    kinds = zip(finding.term.effect.coefficients, finding.term.coefficients, strict=True)
    for kind, value in kinds:
        if not kind.whole_at_one:
            continue
        if not kind.lower <= value <= kind.upper:
            return False
        told = finding.parameters.get(kind.name)
        if told is not None and abs(value - 1.0) > SHARE_OFF * told.std_error_random > 0.0:
            return False
    return True
