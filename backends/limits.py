"""Joint limits for the drives: the profile's, else the URDF's own."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from math import inf

from pa10d.common.urdf_joints import movable_joints
from pa10d.common.urdf_xml import urdf_root
from pa10d.profile import Profile

MOVABLE = ("revolute", "prismatic", "continuous")


@dataclass(frozen=True)
class AxisLimits:
    """One joint: rad and N·m, or m and N where it slides, and s; inf where nothing is known."""

    lower: float
    upper: float
    velocity: float
    acceleration: float
    torque: float
    slides: bool = False


def axis_limits(profile: Profile) -> list[AxisLimits]:
    """Limits of every axis, in the profile's joint order."""
    given, axes = profile.limits, len(profile.drives or [])
    from_urdf = _urdf_limits(profile, axes)
    result = []
    for k in range(axes):
        lower, upper, velocity, effort, slides = from_urdf[k]
        if given.position:
            lower, upper = given.position[k]
        result.append(
            AxisLimits(
                lower=lower,
                upper=upper,
                velocity=given.velocity[k] if given.velocity else velocity,
                acceleration=given.acceleration[k] if given.acceleration else inf,
                torque=given.torque[k] if given.torque else effort,
                slides=slides,
            )
        )
    return result


def _urdf_limits(profile: Profile, axes: int) -> list[tuple[float, float, float, float, bool]]:
    unknown = (-inf, inf, inf, inf, False)
    try:
        root = urdf_root(profile.urdf)
    except (OSError, ValueError):
        return [unknown] * axes
    found: dict[str, tuple[float, float, float, float, bool]] = {}
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        if joint.get("type") in MOVABLE:
            has_range = limit is not None and joint.get("type") != "continuous"
            found[joint.get("name", "")] = (
                _number(limit, "lower", -inf) if has_range else -inf,
                _number(limit, "upper", inf) if has_range else inf,
                _number(limit, "velocity", inf) or inf,
                _number(limit, "effort", inf) or inf,
                joint.get("type") == "prismatic",
            )
    names = profile.joints or movable_joints(root)
    return [found.get(name, unknown) for name in names] if len(names) == axes else [unknown] * axes


def _number(limit: ET.Element | None, key: str, default: float) -> float:
    try:
        return default if limit is None else float(limit.get(key, default))
    except ValueError:
        return default
