"""What speaks for an error that follows no map: each witness in its own words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from pa10d.common.words import joint_words, percent
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.diagnose.unknown.of_joint import OfJoint
from pa10d.diagnose.unknown.place_words import changes_sides, told_in_passing
from pa10d.diagnose.unknown.size_words import ASK_AGAIN
from pa10d.judgement.noise import REPEATS

IN_COMMON: Mapping[str, str] = {
    "sway": "gravity turns to and fro by {degrees:.2g}° (RMS) under the arm: a base that tips or "
    "gives, or a load that swings. Hold the base, or measure how it moves; look at what hangs on "
    "the arm",
    "stamps": "all positions are read earlier or later than their stamps say: rather of the "
    "recording than of the arm. Stamp positions and torques where they are read",
}


def by_witness(one: OfJoint) -> str:
    """Empty where no witness speaks."""
    if not isinstance(one.left, Unnamed) or one.left.witness not in WITNESSES:
        return ""
    return WITNESSES[one.left.witness](one, one.left)


def _too_large(one: OfJoint, left: Unnamed) -> str:
    text = ": more than the noise that can be seen" + (
        f"; {told_in_passing(one.place)}, but the fitted runs do not show the same there"
        if one.place is not None
        else ", but it follows no quantity of the motion clearly enough to say what it depends on"
    )
    text += ". A cause that is not in the recording, or noise that is slow"
    return text if one.source == REPEATS else f"{text}. {ASK_AGAIN}"


def _hums(one: OfJoint, left: Unnamed) -> str:
    return (
        f"; {percent(left.share)} of its squared error is one line in time, at {left.hertz:.3g} Hz "
        "on both sides: no motion, and no slow noise, but a fan, mains, a machine beside, or a "
        "servo or a frame that rings"
    )


def _steps(one: OfJoint, left: Unnamed) -> str:
    return (
        f"; {percent(left.share)} of its squared error is {left.step_words}, at once and not as it "
        "warms: a brake that lets go late, a belt that slips, a seal that breaks loose or seizes"
    )


def _swings(one: OfJoint, left: Unnamed) -> str:
    text = (
        f"; {percent(left.share)} of its squared error swings at about {left.hertz:.2g} Hz when "
        "motion has set it going"
    )
    place = one.place
    if place is not None and changes_sides(place) and place.what.excess > left.share:
        return f"{text}, as a link does that knocks to and fro in a gap"
    return (
        f"{text}, and swings on by itself: {_spring_named(one.springs)}a liquid or a load that is "
        "not tight, a cable, a frame or a gear that gives. Stop quickly and record what swings on, "
        "with the tool and without"
    )


def _spring_named(joints: Sequence[int]) -> str:
    """What is the first to be thought of where something swings on."""
    if not joints:
        return ""
    named = joint_words(sorted(set(joints)))
    return f"the spring that was found in {named}, if it is other than its law has it; or else "


def _in_common(one: OfJoint, left: Unnamed) -> str:
    return (
        f"; the other joints tell {percent(left.share)} of its squared error, moment by moment, as "
        f"where {IN_COMMON[left.witness].format(degrees=left.degrees)}"
    )


def _turns(one: OfJoint, left: Unnamed) -> str:
    return (
        f"; {percent(left.share)} of its squared error is there around reversals and gone in the "
        "middle of the strokes, as no steady noise is: friction that builds up over a way, or is "
        "higher at the lowest speeds. Slow reversals of this joint would show which"
    )


def _reverses(one: OfJoint, left: Unnamed) -> str:
    return (
        f"; {percent(left.share)} of its squared error turns round with the joint, as no noise "
        "does, but follows no quantity of the motion: friction that wanders by itself (a seal, a "
        "lubricant, a temperature that was not measured). One motion twice would show how much"
    )


def _foretold(one: OfJoint, left: Unnamed) -> str:
    return (
        f"; motion predicts {percent(left.share)} of its squared error, best from "
        f"{left.best_from}; no map of one or two quantities surely does"
    )


def _foretold_elsewhere(one: OfJoint, left: Unnamed) -> str:
    return (
        f"; of the fitted runs motion predicts {percent(left.share)} of its squared error, from "
        f"one stretch to another, best from {left.best_from}; no map of one or two quantities "
        "surely does. The runs held out ask for what these do not show: hold out motion like the "
        "fitted one"
    )


WITNESSES: Mapping[str, Callable[[OfJoint, Unnamed], str]] = {
    "size": _too_large,
    "hum": _hums,
    "step": _steps,
    "ring": _swings,
    "sway": _in_common,
    "stamps": _in_common,
    "turning": _turns,
    "reversing": _reverses,
    "motion": _foretold,
    "elsewhere": _foretold_elsewhere,
}
