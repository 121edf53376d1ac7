"""The sentences of a joint's line: how much it keeps, and what this data can say of it.

``RULES`` stand in the order of what says most; the first that has something to say is heard.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from pa10d.common.words import joint_words, listed, percent, rounded, times
from pa10d.compare.places import Place
from pa10d.compare.regions import Region
from pa10d.diagnose.constants import (
    BROKEN_SHARE,
    CLAIMED_SHARE,
    MATERIAL_REST,
    MUCH_WORSE,
    UNSURE_FLOOR,
)
from pa10d.diagnose.unknown.between_runs import Apart
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.diagnose.unknown.geometry import OtherGeometry
from pa10d.diagnose.unknown.of_joint import OfJoint
from pa10d.diagnose.unknown.rubbing import OtherFriction
from pa10d.diagnose.unknown.structure import Structure, moving_of
from pa10d.judgement.noise import REPEATS

ASK_AGAIN = "Record one motion twice: what comes again is no noise"
IN_COMMON: Mapping[str, str] = {
    "sway": "gravity turns to and fro by {degrees:.2g}° (RMS) under the arm: a base that tips or "
    "gives, or a load that swings. Hold the base, or measure how it moves; look at what hangs on "
    "the arm",
    "stamps": "all positions are read earlier or later than their stamps say: rather of the "
    "recording than of the arm. Stamp positions and torques where they are read",
}


def said_of_joint(one: OfJoint) -> str:
    """Its whole line."""
    return f"{_first(one)}{_trace(one)}{_faster(one)}{_not_new(one)}{_moved(one)}{_curve(one)}"


# -- what it says first ----------------------------------------------------------------------------


def _first(one: OfJoint) -> str:
    """How much it keeps, and the one thing to be said first of that."""
    j, size = one.joint, _size(one)
    if one.as_before and not one.told:  # what it depends on is no change
        return f"{size}."
    if one.material is not False and j in one.known.alone and not one.told:
        return f"{size}; {_follows(one)}{one.known.alone[j]}."
    if one.left is None and one.material is not False and j in one.known.undetermined:
        return f"{size}{_not_determined(one.known.undetermined[j])}"
    return f"{_by_rule(one)}{_neighbours(one)}{_outdone(one)}{_gain(one)}{_doubt(one)}"


def _by_rule(one: OfJoint) -> str:
    said = next(filter(None, (rule(one) for rule in RULES)))
    text = f"{_size(one)}{said}"
    return f"{text}{_larger_elsewhere(one, text)}."


def _apart(one: OfJoint) -> str:
    if not isinstance(one.left, Apart):
        return ""
    fit = "a fit to all" if one.left.held_out else "the fit"
    where = _unvisited(one) if one.left.all_along else ""
    return (
        f"; {one.left.who}: {one.left.words}, which is {percent(one.left.share)} of the squared "
        f"error that {fit} leaves there{where}"
    )


def _goes_with_another(one: OfJoint) -> str:
    beside = one.known.beside.get(one.joint)
    if beside is None or not one.size_alone:
        return ""
    return (
        f"; {percent(beside.share)} of its squared error goes with what remains on joint "
        f"{beside.other + 1}: it pays for what is missing there, or both have one cause. Look "
        "there first"
    )


def _other_friction(one: OfJoint) -> str:
    if not isinstance(one.left, OtherFriction):
        return ""
    return f"; {percent(one.left.share)} of its squared error is {one.left.words}"


def _other_geometry(one: OfJoint) -> str:
    if not isinstance(one.left, OtherGeometry):
        return ""
    return (
        f"; {percent(one.left.share)} of its squared error is gone where the arm is not as its "
        f"URDF says: {one.left.words}"
    )


def _where_nobody_was(one: OfJoint) -> str:
    if not one.size_alone or one.material is False or one.repeats:
        return ""
    return _unvisited(one)


def _unvisited(one: OfJoint) -> str:
    beyond = one.beyond
    if beyond is None:
        return ""
    return (
        f"; {percent(beyond.share)} of its squared error lies where {beyond.place}, where the fit "
        "side has not been. Fit to motion that goes there"
    )


def _depends(one: OfJoint) -> str:
    left = one.left
    if left is None or not left.variables:
        return ""
    depends = f"; {percent(left.share)} of its squared error depends on {listed(left.variables)}"
    if isinstance(left, Unnamed) and left.witness == "unseen":
        return (
            f"{depends}, and would be gone with {left.law}, which the fitted runs ask for; but "
            "these do not go where it acts, so nothing confirms it. Hold out motion that does"
        )
    text = f"{depends}, and no effect that was looked for explains it"
    if isinstance(left, Unnamed) and left.witness == "law":
        text += (
            f" in a shape that it may have: {left.law} would, the end of its range, where it is "
            "another law"
        )
    if isinstance(left, Structure) and left.beyond > CLAIMED_SHARE:
        text += f"; {percent(left.beyond)} lies where the fit side has not been"
    rest = one.ratio * float(np.sqrt(max(1.0 - left.share, 0.0)))
    if rest > MATERIAL_REST:
        text += f"; what the rest, {times(rest)} that floor, depends on is not known"
    if (moving := moving_of(one.joint)) in left.variables:
        text += (
            f". {moving}: s since it last stood. A brake that lets go late, or grease or a seal "
            "that has stiffened at rest, acts then"
        )
    if isinstance(left, Unnamed) and left.witness == "reading" and left.share > BROKEN_SHARE:
        text += f". {_read(one.joint, left.variables)}"
    return text


def _read(joint: int, variables: Sequence[str]) -> str:
    if "time" in variables:
        return "A motor or a sensor that reads less, or more, as it warms"
    if variables == (f"tau{joint + 1}",):
        return "A reading with a step, a dead band or a bend: look at how its torque is measured"
    return "A channel that takes on another's torque, or gears that share it"


def _by_witness(one: OfJoint) -> str:
    if not isinstance(one.left, Unnamed) or one.left.witness not in WITNESSES:
        return ""
    return WITNESSES[one.left.witness](one, one.left)


def _comes_again(one: OfJoint) -> str:
    """Of motion that was passed twice, where nothing is claimed, or no more than that."""
    seen = one.seen
    if one.left is None and seen is not None and one.material and one.repeats:
        return (
            f"; {percent(min(seen.share, 1.0))} of its squared error comes again with the motion, "
            "no more than the uncertainty of the model's own coefficients may leave. Fit to more "
            "data"
        )
    if one.left is None and seen is not None and one.material and one.repeats is None:
        return (
            f"; {percent(min(seen.share, 1.0))} of its squared error is alike in both passes of "
            "the motion: too little, or too slow, to tell it from slow noise. Record it once more"
        )
    if not one.repeats or one.left is None:
        return ""
    share = percent(min(seen.share, 1.0)) if seen else "part"
    text = f"; {share} of its squared error comes again with the motion, so it is no noise"
    if one.place is None:
        return f"{text}, but what it depends on is not known"
    return (
        f"{text}; on the runs held out {_told(one.place)}, but the fitted runs do not show the "
        "same there"
    )


def _nothing_claimed(one: OfJoint) -> str:
    place = one.place
    if one.material is False:
        return _explained(one)
    if not one.known.searched:
        return "; what it depends on was not looked for"
    if one.knocked:
        return f"; {one.knocked}"
    if one.material is None and one.rms > MATERIAL_REST * one.most_noise:
        return (
            f", and motion does not predict it. Hardly more than {rounded(one.most_noise, 3)} "
            f"{one.unit} is noise as it was on the runs that the model was fitted to: what "
            f"is more those do not show, or it came since. {ASK_AGAIN}"
        )
    if one.material is None:
        return (
            ", and motion does not predict it: this data cannot say how much of it is noise. "
            "Record one motion twice: what comes again is none"
        )
    if place is None:
        return (
            ", but motion does not predict it: slow noise, or what this data cannot show. "
            f"{ASK_AGAIN}"
        )
    why = (
        "an offset that only these runs have, or noise as slow as they are long"
        if place.variable == "constant"
        else "what the library has not, or slow noise that was larger there"
    )
    return f"; {_told(place)}: {why}. {ASK_AGAIN}"


def _explained(one: OfJoint) -> str:
    """No more than a floor is said of what is left than is known of that floor."""
    unsure = _floor_error(one)
    if unsure <= UNSURE_FLOOR:
        return ": explained to the floor"
    text = ": explained to the floor, as far as that is known"
    return text if unsure < 1.0 or one.source == REPEATS else f"{text}. {ASK_AGAIN}"


RULES: tuple[Callable[[OfJoint], str], ...] = (
    _apart,
    _goes_with_another,
    _other_friction,
    _other_geometry,
    _where_nobody_was,
    _depends,
    _by_witness,
    _comes_again,
    _nothing_claimed,
)


# -- what speaks for an error that follows no map --------------------------------------------------


def _too_large(one: OfJoint, left: Unnamed) -> str:
    text = ": more than the noise that can be seen" + (
        f"; {_told(one.place)}, but the fitted runs do not show the same there"
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
    if place is not None and _changes_sides(place) and place.what.excess > left.share:
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


# -- what is said besides --------------------------------------------------------------------------


def _follows(one: OfJoint) -> str:
    """What the error of a moved model depends on, before what one change takes of it unmoved."""
    if one.left is None or not one.left.variables:
        return ""
    share, on = percent(one.left.share), listed(one.left.variables)
    return f"{share} of its squared error depends on {on}, and "


def _not_determined(fitted: float) -> str:
    """What the fitted runs leave open; of a joint that keeps so many times its floor on these."""
    text = (
        ": the fitted runs do not determine the arm for this motion, and what they leave open of "
        "it may be as much. Fit to motion like this one."
    )
    if not fitted > MATERIAL_REST:
        return text
    return (
        f"{text} But on the fitted runs themselves it keeps {times(fitted)} that floor: so much is "
        "not for want of motion, but something that is missing, or slow noise."
    )


def _larger_elsewhere(one: OfJoint, text: str) -> str:
    """Where more of it lies than its witness speaks of."""
    if not isinstance(one.left, Unnamed) or one.place is None or _told(one.place) in text:
        return ""
    return f". {_with_hint(one.place)}" if one.place.what.excess > one.left.share else ""


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
    return (
        f" Were the joint's torque read differently from {where} to {where}, {gone}: look at how "
        "it is measured."
    )


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


def _size(one: OfJoint) -> str:
    keeps = f"Joint {one.joint + 1} keeps {rounded(one.rms, 3)} {one.unit}"
    if one.source is None:
        return f"{keeps}; its noise floor is not known from this data"
    return f"{keeps}, {times(one.ratio)} its noise floor ({_floor_doubt(one)}from {one.source})"


def _floor_doubt(one: OfJoint) -> str:
    """How unsure the floor itself is, where that changes what a ratio to it says."""
    error = _floor_error(one)
    return f"give or take {100 * error:.0f} %, " if error > UNSURE_FLOOR else ""


def _floor_error(one: OfJoint) -> float:
    """Relative standard error; zero where nothing is known of a floor."""
    return float(one.judged.floor.errors[one.joint]) / one.floor if one.floor > 0.0 else 0.0


def _told(place: Place) -> str:
    said = _with_hint(place)
    return f"{said[0].lower()}{said[1:]}"


def _with_hint(place: Place) -> str:
    """With what acts where a load changes its sign."""
    if not _changes_sides(place):
        return place.sentence
    return (
        f"{place.sentence}: play, or a gear or a belt that gives, acts where a load changes sides"
    )


def _changes_sides(place: Place) -> bool:
    """Does a load change its sign there?"""
    what = place.what
    if not isinstance(what, Region) or what.quantity is None:
        return False
    return what.quantity.kind == "load" and what.low < 0.0 < what.high
