"""The sentences of a joint's line: how much it keeps, and what this data can say of it.

``RULES`` stand in the order of what says most; the first that has something to say is heard.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pa10d.common.words import joint_words, listed, percent, rounded, times
from pa10d.diagnose.constants import (
    BROKEN_SHARE,
    CLAIMED_SHARE,
    MATERIAL_REST,
    UNSURE_FLOOR,
)
from pa10d.diagnose.unknown.between_runs import Apart
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.diagnose.unknown.geometry import OtherGeometry
from pa10d.diagnose.unknown.of_joint import OfJoint
from pa10d.diagnose.unknown.place_words import told_in_passing
from pa10d.diagnose.unknown.rubbing import OtherFriction
from pa10d.diagnose.unknown.said_besides import (
    before_one_change,
    larger_elsewhere,
    not_determined,
    of_other_things,
    of_the_same,
)
from pa10d.diagnose.unknown.said_by_witness import by_witness
from pa10d.diagnose.unknown.size_words import ASK_AGAIN, floor_error, keeps
from pa10d.diagnose.unknown.structure import Structure, moving_of


def said_of_joint(one: OfJoint) -> str:
    """Its whole line."""
    return f"{_first(one)}{of_other_things(one)}"


# -- what it says first ----------------------------------------------------------------------------


def _first(one: OfJoint) -> str:
    """How much it keeps, and the one thing to be said first of that."""
    j, size = one.joint, keeps(one)
    if one.as_before and not one.told:  # what it depends on is no change
        return f"{size}."
    if one.material is not False and j in one.known.alone and not one.told:
        return f"{size}; {before_one_change(one)}{one.known.alone[j]}."
    if knocks := _among_knocks(one):
        return f"{size}{knocks}."
    if one.left is None and one.material is not False and j in one.known.undetermined:
        return f"{size}{not_determined(one)}"
    return f"{_by_rule(one)}{of_the_same(one)}"


def _by_rule(one: OfJoint) -> str:
    said = next(filter(None, (rule(one) for rule in RULES)))
    text = f"{keeps(one)}{said}"
    return f"{text}{larger_elsewhere(one, text)}."


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
        f"{text}; on the runs held out {told_in_passing(one.place)}, but the fitted runs do not "
        "show the same there"
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
    return f"; {told_in_passing(place)}: {why}. {ASK_AGAIN}"


def _among_knocks(one: OfJoint) -> str:
    """Of a joint that keeps no more than noise but where the teeth of a gap meet."""
    found = one.known.knocks.get(one.joint)
    if found is None or not one.material or not one.size_alone:
        return ""
    if not found.rest <= MATERIAL_REST * one.floor:
        return ""
    gap = f"the gap of {joint_words(found.of)}" if len(found.of) == 1 else "gaps"
    return (
        f"; {percent(found.share)} of its squared error lies in the knocks of {gap} "
        f"({percent(found.part)} of its samples), the moments of which nobody can foretell so "
        f"closely. Elsewhere it keeps {times(found.rest / one.floor)} its floor"
    )


def _explained(one: OfJoint) -> str:
    """No more than a floor is said of what is left than is known of that floor."""
    unsure = floor_error(one)
    if unsure <= UNSURE_FLOOR:
        return ": explained to the floor"
    if one.judged.floor.hardly_known[one.joint]:
        return (
            ": a floor so unsure says next to nothing, and this data cannot say how much of it is "
            "noise. Record one motion twice: what comes again is none"
        )
    return ": explained to the floor, as far as that is known"


RULES: tuple[Callable[[OfJoint], str], ...] = (
    _apart,
    _goes_with_another,
    _other_friction,
    _other_geometry,
    _where_nobody_was,
    _depends,
    by_witness,
    _comes_again,
    _nothing_claimed,
)
