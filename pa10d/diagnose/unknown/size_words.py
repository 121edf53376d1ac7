"""How much a joint keeps, beside its noise floor."""

from __future__ import annotations

from pa10d.common.words import rounded, times
from pa10d.diagnose.constants import UNSURE_FLOOR
from pa10d.diagnose.unknown.of_joint import OfJoint

ASK_AGAIN = "Record one motion twice: what comes again is no noise"


def keeps(one: OfJoint) -> str:
    """Of its error, and how many times its noise floor that is."""
    text = f"Joint {one.joint + 1} keeps {rounded(one.rms, 3)} {one.unit}"
    if one.source is None:
        return f"{text}; its noise floor is not known from this data"
    return f"{text}, {times(one.ratio)} its noise floor ({_floor_doubt(one)}from {one.source})"


def _floor_doubt(one: OfJoint) -> str:
    """How unsure the floor itself is, where that changes what a ratio to it says."""
    error = floor_error(one)
    return f"give or take {100 * error:.0f} %, " if error > UNSURE_FLOOR else ""


def floor_error(one: OfJoint) -> float:
    """Relative standard error; zero where nothing is known of a floor."""
    return float(one.judged.floor.errors[one.joint]) / one.floor if one.floor > 0.0 else 0.0
