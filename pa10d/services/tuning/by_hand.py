"""A profile that was written by hand: looked at as Tune looks at a change, before the arm moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pa10d.common.words import joint_words
from pa10d.experiments.checks import Check
from pa10d.profile import Gains
from pa10d.services.robots import load_robot
from pa10d.services.tuning.arm import Tuned
from pa10d.services.tuning.doubts import Swings, others_than, swinging, wider
from pa10d.services.tuning.keys import KEYS

LEAVE_OUT = "leave control.gains out: then a rule gives them, and first_motion measures what fits"


def gain_checks(tuned: Tuned) -> list[Check]:
    """Gains that the profile states: an error where no pose may be held with them for long."""
    return [
        Check(
            "warning" if np.isfinite(one.peak) else "error",
            "gains",
            f"{one.sentence}; {LEAVE_OUT}",
            one.joint + 1,
        )
        for one in _swinging(tuned)
    ]


def range_checks(tuned: Tuned) -> list[Check]:
    """Position limits beyond those of the URDF."""
    bare = tuned.bare
    as_urdf = replace(tuned, robot=replace(tuned.robot, lower=bare.lower, upper=bare.upper))
    found = wider(KEYS["limits.position"], as_urdf, tuned)
    return [Check("warning", "limits", sentence) for sentence in found]


def why_not_held(data: str, profile: str, gains: Mapping[str, Any]) -> str | None:
    """Why an arm is not powered with the gains that its profile states; None: it may be. gains: as
    they are in force, whatever stands in the file by now."""
    found, robot = load_robot(profile)
    control = found.control.model_copy(update={"gains": Gains.model_validate(gains)})
    tuned = Tuned.of(data, found.model_copy(update={"control": control}), robot)
    return _unstable_words(_unstable(tuned))


def why_not_tuned(before: Tuned, after: Tuned) -> str | None:
    """Why a change is not made that no confirmation would let the arm be powered with, in the same
    words. What was so before, and stays as it was, is left to whoever mends it joint by joint."""
    known = _unstable(before)
    changed = others_than(before, after)
    return _unstable_words([j for j in _unstable(after) if j not in known or changed[j]])


def _unstable(tuned: Tuned) -> list[int]:
    """Joints, from 0."""
    return [one.joint for one in _swinging(tuned) if not np.isfinite(one.peak)]


def _unstable_words(joints: list[int]) -> str | None:
    if not joints:
        return None
    what = "the gains that the profile states make a loop that is not stable in the worst pose"
    return f"{joint_words(joints)}: {what}; {LEAVE_OUT}"


def _swinging(tuned: Tuned) -> list[Swings]:
    """What the rule, or what was measured, would give is not judged here."""
    profile = tuned.profile
    if profile.control.gains == Gains():
        return []
    control = profile.control.model_copy(update={"gains": Gains()})
    ruled = tuned.with_profile(profile.model_copy(update={"control": control}), tuned.robot)
    return list(swinging(ruled, tuned))
