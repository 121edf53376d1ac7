"""What is said of a joint besides the one thing that is said first."""

from __future__ import annotations

import numpy as np

from pa10d.common.words import listed, percent, rounded, times
from pa10d.diagnose.constants import BROKEN_SHARE, MATERIAL_REST, MUCH_WORSE
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.diagnose.unknown.of_joint import OfJoint
from pa10d.diagnose.unknown.place_words import told, told_in_passing
from pa10d.diagnose.unknown.structure import Structure


def of_the_same(one: OfJoint) -> str:
    """What else is known of what was said first."""
    return f"{_neighbours(one)}{_outdone(one)}{_dead_band(one)}{_gain(one)}{_doubt(one)}"


def of_other_things(one: OfJoint) -> str:
    """What stands behind all of that."""
    return f"{_trace(one)}{_faster(one)}{_not_new(one)}{_moved(one)}{_curve(one)}"


def before_one_change(one: OfJoint) -> str:
    """What the error of a moved model depends on, before what one change takes of it unmoved."""
    if one.left is None or not one.left.variables:
        return ""
    share, on = percent(one.left.share), listed(one.left.variables)
    return f"{share} of its squared error depends on {on}, and "


def not_determined(one: OfJoint) -> str:
    """What the fitted runs leave open, and how many times its floor a joint keeps on these."""
    begins = ". The" if one.source is None else ": the"  # why no floor is known, that is not
    text = (
        f"{begins} fitted runs do not determine the arm for this motion, and what they leave open "
        "of it may be as much. Fit to motion like this one."
    )
    fitted = one.known.undetermined[one.joint]
    if not fitted > MATERIAL_REST:
        return text
    return (
        f"{text} But on the fitted runs themselves it keeps {times(fitted)} that floor: so much is "
        "not for want of motion, but something that is missing, or slow noise."
    )


def larger_elsewhere(one: OfJoint, text: str) -> str:
    """Where more of it lies than its witness speaks of."""
    if not isinstance(one.left, Unnamed) or one.place is None or told_in_passing(one.place) in text:
        return ""
    return f". {told(one.place)}" if one.place.what.excess > one.left.share else ""


def _neighbours(one: OfJoint) -> str:
    """What pulls at one joint by two angles pulls at another by the same, often too weakly to be
    sure of."""
    if not isinstance(one.left, Unnamed) or one.left.witness != "motion":
        return ""
    maps = [a for a in one.others if isinstance(a, Structure) and len(a.variables) > 1]
    if not maps:
        return ""
    return f" Or it is {listed(maps[0].variables)}, as on joint {maps[0].joint + 1}."


def _outdone(one: OfJoint) -> str:
    """What took most of an error, of which a map leaves much less."""
    named, share = one.known.outdone.get(one.joint, ((), 0.0))
    if not isinstance(one.left, Structure) or share <= BROKEN_SHARE:
        return ""
    return (
        f" What looks like {listed(named)} there ({percent(share)} of its squared error) is part "
        "of that: alone it leaves much more than a map."
    )


def _dead_band(one: OfJoint) -> str:
    """What a threshold of its reading would explain, and what only imitated that."""
    if one.joint not in one.known.dead_bands:
        return ""
    size, share = one.known.dead_bands[one.joint]
    named, _ = one.known.outdone.get(one.joint, ((), 0.0))
    return (
        f" Were its torque read as nothing up to {rounded(size, 2)} {one.unit}, and as less by "
        f"that beyond it (a dead band), {percent(share)} would be gone, more than with "
        f"{listed(named)}"
        f"{_look(one)}."
    )


def _gain(one: OfJoint) -> str:
    """What a reading would explain that is larger here and smaller there; beside findings on the
    joint only that it leaves less than they do."""
    gain = one.known.gains.get(one.joint)
    if gain is None:
        return ""
    where = "speed" if gain.variables[0].startswith("dq") else "angle"
    gone = (
        "that alone would leave less than what was found there"
        if one.on_found
        else f"{percent(gain.share)} would be gone"
    )
    return f" Were the joint's torque read differently from {where} to {where}, {gone}{_look(one)}."


def _look(one: OfJoint) -> str:
    """What to do, where it is not said."""
    read = isinstance(one.left, Unnamed) and one.left.witness == "reading"
    return "" if read else ": look at how it is measured"


def _doubt(one: OfJoint) -> str:
    """Where coefficients that little data leave open make as large an error, the next thing to have
    is more data to fit, whatever the noise."""
    if one.left is not None or one.material is False or one.repeats or one.known.doubt is None:
        return ""
    doubt, floor = float(one.known.doubt[one.joint]), one.floor if one.floor > 0 else 0.0
    if doubt <= 0.0 or np.hypot(MATERIAL_REST * floor, doubt) < one.rms:
        return ""
    return " The uncertainty of the model's own coefficients may leave as much: fit to more data."


def _trace(one: OfJoint) -> str:
    if one.trace is None:
        return ""
    return (
        f" {percent(one.trace.share).capitalize()} of its squared error depends on "
        f"{listed(one.trace.variables)}: too little to claim anything."
    )


def _faster(one: OfJoint) -> str:
    """What the band does not let through."""
    said = one.known.faster.get(one.joint, "")
    return f" {said[0].upper()}{said[1:]}." if said and one.material is not False else ""


def _not_new(one: OfJoint) -> str:
    """Of a model that stays as it was, and of its own data."""
    if not one.as_before:
        return ""
    if one.rms <= (1.0 + MUCH_WORSE) * one.lacked:
        return (
            " The model lacked about as much on the data that it was identified from: ask what is "
            "missing, not what changed."
        )
    return (
        f" On the data that it was identified from the model left {rounded(one.lacked, 3)} "
        f"{one.unit}, and another motion may show twice what it lacked there: ask what "
        "is missing. What has changed a recording of the same motion would show."
    )


def _moved(one: OfJoint) -> str:
    if one.left_unmoved is None:
        return ""
    return (
        f" Where it was not moved the model leaves {rounded(one.left_unmoved, 3)} {one.unit} "
        "there: within its own doubt it was moved to suit the fitted runs."
    )


def _curve(one: OfJoint) -> str:
    """Where several findings of a joint follow its angle, and what is left does so, too: a curve
    that the library lacks is put together of those that it has."""
    if one.left is None or one.left.variables != (f"q{one.joint + 1}",):
        return ""
    of_angle = [t for t in one.known.found if t.joints == (one.joint,) and t.effect.follows_angle]
    if len(of_angle) < 2:
        return ""
    named = list(dict.fromkeys(t.effect.named for t in of_angle))
    return f" What was found there, {listed(named)}, may be no more than parts of one such curve."
