"""What is left of every joint's error, and what this data can say about it. Always a line each."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject, plain
from pa10d.common.words import joint_words, listed, percent, times
from pa10d.compare.places import Place
from pa10d.compare.regions import Region
from pa10d.diagnose.constants import (
    AT_RANDOM,
    BEYOND_NOISE,
    BEYOND_NOISE_LEVEL,
    BEYOND_SLOW_NOISE,
    BROKEN_SHARE,
    CLAIMED_SHARE,
    COMES_AGAIN_LEVEL,
    MATERIAL_REST,
    MUCH_WORSE,
)
from pa10d.diagnose.unknown.between_runs import Apart
from pa10d.diagnose.unknown.beyond import Beyond
from pa10d.diagnose.unknown.common_cause import InCommon
from pa10d.diagnose.unknown.geometry import OtherGeometry
from pa10d.diagnose.unknown.goes_with import GoesWith
from pa10d.diagnose.unknown.humming import Hum
from pa10d.diagnose.unknown.ringing import SwingsOn
from pa10d.diagnose.unknown.rubbing import OtherFriction
from pa10d.diagnose.unknown.stepping import StepInTime
from pa10d.diagnose.unknown.structure import Structure, moving_of
from pa10d.judgement import Judgement, Reversing, Turning
from pa10d.judgement.noise import REPEATS
from pa10d.judgement.repeatable import Repeatable
from pa10d.model import Term

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Unnamed:
    """Structure of which no map says what it depends on: share of the joint's squared error that
    comes again with the motion, that motion predicts (of the fit side alone, where the held-out
    side moves elsewhere), that is gone in the middle of its strokes, that turns round with the
    joint, that is beyond any noise the data show, that depends on torque as it is read, that is one
    line in time at so many hertz, that motion sets swinging at so many, that is gone where the
    joint may change at so many seconds of these runs (empty: of every run), or that a law takes at
    the end of what its shape may be, in words, or that other joints tell of a base that sways by so
    many degrees or of stamps that scatter; best_from: what foretells it, in words; RMS N·m of that
    share."""

    joint: int
    share: float
    rms: float
    p_value: float
    witness: Literal[
        "again",
        "motion",
        "elsewhere",
        "turning",
        "reversing",
        "size",
        "reading",
        "hum",
        "ring",
        "step",
        "law",
        "sway",
        "stamps",
    ]
    variables: tuple[str, ...] = ()
    hertz: float = float("nan")
    seconds: float = float("nan")
    runs: tuple[str, ...] = ()
    law: str = ""
    best_from: str = ""
    degrees: float = float("nan")

    @classmethod
    def of_hum(cls, hum: Hum) -> Unnamed:
        """A line in time."""
        return cls(hum.joint, hum.share, hum.rms, hum.p_value, "hum", hertz=hum.hertz)

    @classmethod
    def of_step(cls, step: StepInTime) -> Unnamed:
        """A change at one moment."""
        at, runs = step.seconds, step.runs
        return cls(step.joint, step.share, step.rms, step.p_value, "step", seconds=at, runs=runs)

    @property
    def step_words(self) -> str:
        """``gone if its friction or offset changes at t = 6 s of every run``."""
        where = listed(self.runs) or "every run"
        return f"gone if its friction or offset changes at t = {self.seconds:.3g} s of {where}"

    @classmethod
    def of_common(cls, one: InCommon) -> Unnamed:
        """What other joints tell of."""
        angle = float(np.degrees(one.size))
        return cls(one.joint, one.share, one.rms, one.p_value, one.cause, degrees=angle)

    @classmethod
    def of_ring(cls, ring: SwingsOn) -> Unnamed:
        """What motion sets swinging."""
        return cls(ring.joint, ring.share, ring.rms, ring.p_value, "ring", hertz=ring.hertz)


Unexplained = Structure | Unnamed | Apart | OtherGeometry | OtherFriction


@dataclass(frozen=True)
class Remaining:
    """One joint (0-based) after all that was found. rms, floor: N·m, floor nan where not known;
    source: how the floor was found; repeatable: does it come again with the motion (None: no
    motion comes again, or too little of it)."""

    joint: int
    rms: float
    floor: float
    source: str | None
    significant: bool
    material: bool | None
    repeatable: bool | None
    depends_on: tuple[str, ...]
    sentence: str

    @property
    def ratio(self) -> float:
        """Error over noise floor; nan where the floor is not known."""
        return self.rms / self.floor if self.floor > 0 else float("nan")

    def document(self) -> JsonObject:
        """As JSON; null: not known."""
        return {
            "joint": self.joint + 1,
            "rms": self.rms,
            "floor": plain(self.floor),
            "floor_source": self.source,
            "ratio": plain(self.ratio),
            "significant": self.significant,
            "material": self.material,
            "repeatable": self.repeatable,
            "depends_on": list(self.depends_on),
            "sentence": self.sentence,
        }


def material(
    judged: Judgement, maps: Sequence[Structure]
) -> tuple[list[Structure], list[Structure]]:
    """Maps that are worth a claim, and slight ones: of a joint that stands at its noise floor
    already, and whose error without what the map says would hardly be smaller. Coarse encoders and
    the servo that answers to them leave such traces of the motion in an error that is noise."""
    least = 1.0 - 1.0 / MATERIAL_REST**2
    worth: list[Structure] = []
    slight: list[Structure] = []
    for m in maps:
        little = judged.ratio[m.joint] < MATERIAL_REST and m.share < least
        (slight if little else worth).append(m)
    return worth, slight


def unnamed(
    judged: Judgement,
    again: Sequence[Repeatable | None],
    known: Sequence[Unexplained],
    doubt: Array,
    by_size: bool = True,
    turned: Sequence[Turning | None] = (),
    reversed_: Sequence[Reversing | None] = (),
    silent: Collection[int] = (),
) -> list[Unnamed]:
    """Joints for which no map was found, and whose error, materially above the floor, comes again,
    is larger after reversals or turns round with the joint, or (by_size) is larger than noise can
    be. doubt (n,) N·m: what the uncertainty of the model's own coefficients may leave; that comes
    again, too, and is nothing missing; silent: joints of which no sample counts."""
    floor, rms = judged.floor.values, judged.rms
    named = {*(s.joint for s in known), *silent}
    out = []
    for j, seen in enumerate(again):
        if j in named:
            continue
        if seen is not None and comes_again(seen, len(again)):
            if rms[j] > np.hypot(MATERIAL_REST * floor[j], doubt[j]):
                size = float(rms[j]) * float(np.sqrt(min(seen.share, 1.0)))
                out.append(Unnamed(j, seen.share, size, seen.p_value, "again"))
        elif (after := _sure(turned, j)) is not None:
            if rms[j] > np.hypot(MATERIAL_REST * floor[j], doubt[j]):
                size = float(rms[j]) * float(np.sqrt(after.share))
                out.append(Unnamed(j, after.share, size, after.p_value, "turning"))
        elif (sided := _sure(reversed_, j)) is not None:
            if rms[j] > np.hypot(MATERIAL_REST * floor[j], doubt[j]):
                size = float(rms[j]) * float(np.sqrt(sided.share))
                out.append(Unnamed(j, sided.share, size, sided.p_value, "reversing"))
        elif by_size and rms[j] > np.hypot(_largest_noise(judged, j), doubt[j]):
            share = 1.0 - (floor[j] / rms[j]) ** 2
            size = float(rms[j]) * float(np.sqrt(share))
            out.append(Unnamed(j, float(share), size, BEYOND_NOISE_LEVEL / len(again), "size"))
    return out


def doubtful(judged: Judgement, fitted: Array, doubt: Array) -> Array:
    """(n,) N·m: the doubt of the model's coefficients, where it can be why a joint keeps an error.
    Of one whose error on the fit side, to which they were fitted, is larger than noise can be
    (fitted, (n,) N·m), it is not."""
    most = np.array([_largest_noise(judged, j) for j in range(len(fitted))])
    return np.where(fitted > most, 0.0, doubt)


def _sure(heard: Sequence[Turning | Reversing | None], j: int) -> Turning | Reversing | None:
    """What says that a joint's error knows of reversals more than noise would by accident."""
    seen = heard[j] if heard else None
    sure = seen is not None and seen.p_value * len(heard) < COMES_AGAIN_LEVEL
    return seen if seen is not None and sure and seen.share > CLAIMED_SHARE else None


def _largest_noise(judged: Judgement, j: int) -> float:
    """N·m. Only its size speaks for such an error, so it has to be many times the floor, doubt
    of it included; more where slow noise was not seen, because no motion came again. Where noise
    grows towards the band, it may be as much stronger there as it then can be at most."""
    times = BEYOND_NOISE if judged.floor.methods[j] == REPEATS else BEYOND_SLOW_NOISE
    times = max(times, float(judged.floor.slow[j]))
    sure = scipy.stats.norm.isf(BEYOND_NOISE_LEVEL / len(judged.rms))
    return times * float(judged.floor.values[j] + sure * judged.floor.errors[j])


def comes_again(seen: Repeatable, joints: int) -> bool:
    """Is it no accident, among so many joints, that two passes of a motion leave alike errors?"""
    return seen.p_value * joints < COMES_AGAIN_LEVEL and seen.share > CLAIMED_SHARE


def remaining(
    judged: Judgement,
    again: Sequence[Repeatable | None],
    unexplained: Sequence[Unexplained],
    units: Sequence[str],
    found: Sequence[Term] = (),
    slight: Sequence[Structure] = (),
    doubt: Array | None = None,
    beyond: Sequence[Beyond | None] = (),
    usual: Array | None = None,
    searched: bool = True,
    gains: Mapping[int, Structure] | None = None,
    stand_out: Sequence[Place] = (),
    silent: Mapping[int, str] | None = None,
    undetermined: Mapping[int, float] | None = None,
    faster: Mapping[int, str] | None = None,
    beside: Mapping[int, GoesWith] | None = None,
    moved: Collection[int] = (),
    as_given: Array | None = None,
    knocked: Mapping[int, str] | None = None,
    outdone: Mapping[int, tuple[tuple[str, ...], float]] | None = None,
    most_noise: Array | None = None,
    alone: Mapping[int, str] | None = None,
    lacked: Array | None = None,
) -> tuple[Remaining, ...]:
    """A line per joint; judged: of the model with all findings, on the held-out side; found: their
    terms; slight: what is significant there and too small for a claim; doubt (n,) N·m: what the
    uncertainty of the model's own coefficients may leave; beyond: per joint where on the held-out
    side its error lies, if that is where the fit side has not been; usual (n,) N·m: what a model
    that is kept as it was may leave though nothing changed; searched: more than one suspicion was
    looked for; gains: by joint, such as sway and explain more than its map or findings do;
    stand_out: parts of the motion in which errors are larger, the gravest first, where noise as
    slow as gravity may be, too; silent: joints of which no sample counts, and why; undetermined:
    joints of which the fitted runs leave open as much as they keep, for the motion held out, and
    how many times the floor they keep on the fitted runs; faster: by joint, in words, what the band
    does not let through; beside: by joint, whose rest its own goes with; moved: joints on which a
    frozen model leaves so little because it was moved; as_given (n,) N·m: what a frozen model
    leaves as it was; knocked: by joint, in words, of those whose error lies in a few moments of the
    runs; outdone: by joint, effects that would take such a share of it, of which a map leaves much
    less; most_noise (n,) N·m RMS: as much of it as there is on the runs that the model was fitted
    to, at most; alone: by joint, in words, what one change takes of what a frozen model leaves as
    it was; lacked (n,) N·m: what that model left on the data that it was identified from."""
    of_joint = {one.joint: one for one in unexplained}
    traces = {one.joint: one for one in slight}
    out = []
    for j, seen in enumerate(again):
        if silent and j in silent:
            out.append(_not_judged(j, float(judged.rms[j]), silent[j]))
            continue
        left = of_joint.get(j)
        floor, ratio = float(judged.floor.values[j]), float(judged.ratio[j])
        material = bool(ratio > MATERIAL_REST) if np.isfinite(ratio) else None
        repeats = _repeats(seen, len(again))
        significant = left is not None
        line = Remaining(
            joint=j,
            rms=float(judged.rms[j]),
            floor=floor,
            source=judged.floor.methods[j],
            significant=significant,
            material=material if left is None else True,
            repeatable=repeats,
            depends_on=() if left is None else left.variables,
            sentence="",
        )
        line = _with_sentence(
            line,
            left,
            seen,
            units[j],
            beyond[j] if beyond else None,
            searched,
            next((p for p in stand_out if p.joint == j), None),
            (beside or {}).get(j),
            [t.joints[0] for t in found if t.effect.series_spring],
            (knocked or {}).get(j, ""),
            float("inf") if most_noise is None else float(most_noise[j]),
        )
        if isinstance(left, Unnamed) and left.witness == "motion":
            line = _with_neighbours(line, [one for one in unexplained if one.joint != j])
        if isinstance(left, Structure) and outdone and outdone.get(j, ((), 0.0))[1] > BROKEN_SHARE:
            line = _with_outdone(line, *outdone[j])
        if gains and j in gains:
            line = _with_gain(line, gains[j], any(j in t.joints for t in found))
        kept = usual is not None and line.material is not False and line.rms <= usual[j]
        kept = kept and j not in moved
        told = isinstance(left, Apart | OtherGeometry | OtherFriction) or j in (knocked or {})
        if kept and not told:  # what it depends on is no change
            line = replace(line, sentence=f"{_size(line, units[j])}.")
        elif line.material is not False and alone and j in alone and not told:
            line = replace(line, sentence=f"{_size(line, units[j])}; {_follows(left)}{alone[j]}.")
        elif left is None and line.material is not False and undetermined and j in undetermined:
            line = replace(line, sentence=_size(line, units[j]) + _open(undetermined[j]))
        elif left is None and line.material is not False and not line.repeatable:
            line = _with_doubt(line, 0.0 if doubt is None else float(doubt[j]))
        if left is None and j in traces and not kept:
            line = _with_trace(line, traces[j])
        if line.material is not False and faster and j in faster:
            text = f" {faster[j][0].upper()}{faster[j][1:]}."
            line = replace(line, sentence=line.sentence + text)
        if kept:
            line = replace(line, sentence=line.sentence + _not_new(line, lacked, units[j]))
        if as_given is not None and line.rms > (1.0 + MUCH_WORSE) * as_given[j]:
            text = MOVED_AWAY.format(given=f"{as_given[j]:.3g}", unit=units[j])
            line = replace(line, sentence=line.sentence + text)
        if parts := _of_one_curve(line, found):
            line = replace(line, sentence=line.sentence + parts)
        out.append(line)
    return tuple(out)


def _open(fitted: float) -> str:
    """What the fitted runs leave open; of a joint that keeps so many times its floor on these."""
    text = FITTED_AS_WELL.format(ratio=times(fitted)) if fitted > MATERIAL_REST else ""
    return NOT_DETERMINED + text


def _follows(left: Unexplained | None) -> str:
    """What the error of a moved model depends on, before what one change takes of it unmoved."""
    if left is None or not left.variables:
        return ""
    return f"{percent(left.share)} of its squared error depends on {listed(left.variables)}, and "


def _not_new(line: Remaining, lacked: Array | None, unit: str) -> str:
    before = line.rms if lacked is None else float(lacked[line.joint])
    if line.rms <= (1.0 + MUCH_WORSE) * before:
        return NOT_NEW
    return NO_MORE_THAN_USUAL.format(lacked=f"{before:.3g}", unit=unit)


def _not_judged(joint: int, rms: float, why: str) -> Remaining:
    text = f"Nothing was looked for on joint {joint + 1}: {why}."
    return Remaining(joint, rms, float("nan"), None, False, None, None, (), text)


NOT_DETERMINED = (
    ": the fitted runs do not determine the arm for this motion, and what they leave open of it "
    "may be as much. Fit to motion like this one."
)
FORETOLD: Mapping[str, str] = {
    "motion": "motion predicts {share} of its squared error, {best}",
    "elsewhere": "of the fitted runs motion predicts {share} of its squared error, from one "
    "stretch to another, {best}. The runs held out ask for what these do not show: hold out motion "
    "like the fitted one",
}
IN_COMMON: Mapping[str, str] = {
    "sway": "gravity turns to and fro by {degrees:.2g}° (RMS) under the arm: a base that tips or "
    "gives, or a load that swings. Hold the base, or measure how it moves; look at what hangs on "
    "the arm",
    "stamps": "all positions are read earlier or later than their stamps say: rather of the "
    "recording than of the arm. Stamp positions and torques where they are read",
}
FITTED_AS_WELL = (
    " But on the fitted runs themselves it keeps {ratio} that floor: so much is not for want of "
    "motion, but something that is missing, or slow noise."
)
MOVED_AWAY = (
    " Where it was not moved the model leaves {given} {unit} there: within its own doubt it was "
    "moved to suit the fitted runs."
)
NOT_NEW = (
    " The model lacked about as much on the data that it was identified from: ask what is missing, "
    "not what changed."
)
NO_MORE_THAN_USUAL = (
    " On the data that it was identified from the model left {lacked} {unit}, and another motion "
    "may show twice what it lacked there: ask what is missing. What has changed a recording of the "
    "same motion would show."
)


def _with_trace(line: Remaining, trace: Structure) -> Remaining:
    text = (
        f" {percent(trace.share).capitalize()} of its squared error depends on "
        f"{listed(trace.variables)}: too little to claim anything."
    )
    return replace(line, significant=True, sentence=line.sentence + text)


def _with_doubt(line: Remaining, doubt: float) -> Remaining:
    """Where coefficients that little data leave open make as large an error, the next thing to have
    is more data to fit, whatever the noise."""
    floor = line.floor if line.floor > 0 else 0.0
    if doubt <= 0.0 or np.hypot(MATERIAL_REST * floor, doubt) < line.rms:
        return line
    text = " The uncertainty of the model's own coefficients may leave as much: fit to more data."
    return replace(line, sentence=line.sentence + text)


def _of_one_curve(line: Remaining, found: Sequence[Term]) -> str:
    """Where several findings of a joint follow its angle, and what is left does so, too: a curve
    that the library lacks is put together of those that it has."""
    if line.depends_on != (f"q{line.joint + 1}",):
        return ""
    of_angle = [t for t in found if t.joints == (line.joint,) and t.effect.follows_angle]
    if len(of_angle) < 2:
        return ""
    named = list(dict.fromkeys(t.effect.named for t in of_angle))
    return f" What was found there, {listed(named)}, may be no more than parts of one such curve."


def _repeats(seen: Repeatable | None, joints: int) -> bool | None:
    if seen is None:
        return None
    if comes_again(seen, joints):
        return True
    return False if seen.p_value > AT_RANDOM or seen.share < CLAIMED_SHARE else None


def _with_sentence(
    line: Remaining,
    left: Unexplained | None,
    seen: Repeatable | None,
    unit: str,
    beyond: Beyond | None,
    searched: bool,
    place: Place | None,
    beside: GoesWith | None,
    springs: Sequence[int],
    knocked: str,
    most_noise: float,
) -> Remaining:
    """springs: joints (0-based) in which one was found: what swings on may be that one; knocked:
    where in time its error lies, if it lies in a few moments; most_noise: N·m RMS, inf where not
    known."""
    size = _size(line, unit)
    unsaid = left is None or (isinstance(left, Unnamed) and left.witness == "size")
    if isinstance(left, Apart):
        fit = "a fit to all" if left.held_out else "the fit"
        text = (
            f"{size}; {left.who}: {left.words}, which is {percent(left.share)} of the squared "
            f"error that {fit} leaves there"
        )
    elif beside is not None and unsaid:
        text = (
            f"{size}; {percent(beside.share)} of its squared error goes with what remains on joint "
            f"{beside.other + 1}: it pays for what is missing there, or both have one cause. Look "
            "there first"
        )
    elif isinstance(left, OtherFriction):
        text = f"{size}; {percent(left.share)} of its squared error is {left.words}"
    elif isinstance(left, OtherGeometry):
        text = (
            f"{size}; {percent(left.share)} of its squared error is gone where the arm is not as "
            f"its URDF says: {left.words}"
        )
    elif beyond is not None and unsaid and line.material is not False and not line.repeatable:
        text = (
            f"{size}; {percent(beyond.share)} of its squared error lies where {beyond.place}, "
            "where the fit side has not been. Fit to motion that goes there"
        )
    elif left is not None and left.variables:
        text = (
            f"{size}; {percent(left.share)} of its squared error depends on "
            f"{listed(left.variables)}, and no effect that was looked for explains it"
        )
        if isinstance(left, Unnamed) and left.witness == "law":
            text += (
                f" in a shape that it may have: {left.law} would, the end of its range, where it "
                "is another law"
            )
        if isinstance(left, Structure) and left.beyond > CLAIMED_SHARE:
            text += f"; {percent(left.beyond)} lies where the fit side has not been"
        rest = line.ratio * float(np.sqrt(max(1.0 - left.share, 0.0)))
        if rest > MATERIAL_REST:
            text += f"; what the rest, {times(rest)} that floor, depends on is not known"
        if (moving := moving_of(line.joint)) in left.variables:
            text += (
                f". {moving}: s since it last stood. A brake that lets go late, or grease or a "
                "seal that has stiffened at rest, acts then"
            )
        if isinstance(left, Unnamed) and left.witness == "reading" and left.share > BROKEN_SHARE:
            text += f". {_read(line.joint, left.variables)}"
    elif isinstance(left, Unnamed) and left.witness == "size":
        text = f"{size}: more than the noise that can be seen"
        text += (
            f"; {_told(place)}, but the fitted runs do not show the same there"
            if place is not None
            else ", but it follows no quantity of the motion clearly enough to say what it depends "
            "on"
        )
        text += ". A cause that is not in the recording, or noise that is slow"
        text += (
            ""
            if line.source == REPEATS
            else ". Record one motion twice: what comes again is no noise"
        )
    elif isinstance(left, Unnamed) and left.witness == "hum":
        text = (
            f"{size}; {percent(left.share)} of its squared error is one line in time, at "
            f"{left.hertz:.3g} Hz on both sides: no motion, and no slow noise, but a fan, mains, a "
            "machine beside, or a servo or a frame that rings"
        )
    elif isinstance(left, Unnamed) and left.witness == "step":
        text = (
            f"{size}; {percent(left.share)} of its squared error is {left.step_words}, at once and "
            "not as it warms: a brake that lets go late, a belt that slips, a seal that breaks "
            "loose or seizes"
        )
    elif isinstance(left, Unnamed) and left.witness == "ring":
        text = (
            f"{size}; {percent(left.share)} of its squared error swings at about {left.hertz:.2g} "
            "Hz when motion has set it going"
        )
        if place is not None and _changes_sides(place) and place.what.excess > left.share:
            text += ", as a link does that knocks to and fro in a gap"
        else:
            text += (
                f", and swings on by itself: {_spring_named(springs)}a liquid or a load that is "
                "not tight, a cable, a frame or a gear that gives. Stop quickly and record what "
                "swings on, with the tool and without"
            )
    elif isinstance(left, Unnamed) and left.witness in IN_COMMON:
        text = (
            f"{size}; the other joints tell {percent(left.share)} of its squared error, moment by "
            f"moment, as where {IN_COMMON[left.witness].format(degrees=left.degrees)}"
        )
    elif isinstance(left, Unnamed) and left.witness == "turning":
        text = (
            f"{size}; {percent(left.share)} of its squared error is there around reversals and "
            "gone in the middle of the strokes, as no steady noise is: friction that builds up "
            "over a way, or is higher at the lowest speeds. Slow reversals of this joint would "
            "show which"
        )
    elif isinstance(left, Unnamed) and left.witness == "reversing":
        text = (
            f"{size}; {percent(left.share)} of its squared error turns round with the joint, as no "
            "noise does, but follows no quantity of the motion: friction that wanders by itself (a "
            "seal, a lubricant, a temperature that was not measured). One motion twice would show "
            "how much"
        )
    elif isinstance(left, Unnamed) and left.witness in FORETOLD:
        text = f"{size}; " + FORETOLD[left.witness].format(
            share=percent(left.share),
            best=f"best from {left.best_from}; no map of one or two quantities surely does",
        )
    elif seen is not None and line.repeatable and line.material and left is None:
        text = (
            f"{size}; {percent(min(seen.share, 1.0))} of its squared error comes again with the "
            "motion, no more than the uncertainty of the model's own coefficients may leave. Fit "
            "to more data"
        )
    elif seen is not None and line.repeatable is None and line.material and left is None:
        text = (
            f"{size}; {percent(min(seen.share, 1.0))} of its squared error is alike in both passes "
            "of the motion: too little, or too slow, to tell it from slow noise. Record it "
            "once more"
        )
    elif line.repeatable and line.significant:
        share = percent(min(seen.share, 1.0)) if seen else "part"
        text = (
            f"{size}; {share} of its squared error comes again with the motion, so it is no noise"
        )
        text += (
            ", but what it depends on is not known"
            if place is None
            else f"; on the runs held out {_told(place)}, but the fitted runs do not show the same "
            "there"
        )
    elif line.material is False:
        text = f"{size}: explained to the floor"
    elif not searched:
        text = f"{size}; what it depends on was not looked for"
    elif knocked:
        text = f"{size}; {knocked}"
    elif line.material is None and line.rms > MATERIAL_REST * most_noise:
        text = (
            f"{size}, and motion does not predict it. Hardly more than {most_noise:.3g} {unit} is "
            "noise as it was on the runs that the model was fitted to: what is more those do not "
            "show, or it came since. Record one motion twice: what comes again is no noise"
        )
    elif line.material is None:
        text = (
            f"{size}, and motion does not predict it: this data cannot say how much of it is "
            "noise. Record one motion twice: what comes again is none"
        )
    elif place is not None:
        why = (
            "an offset that only these runs have, or noise as slow as they are long"
            if place.variable == "constant"
            else "what the library has not, or slow noise that was larger there"
        )
        text = (
            f"{size}; {_told(place)}: {why}. Record one motion twice: what comes again is no noise"
        )
    else:
        text = (
            f"{size}, but motion does not predict it: slow noise, or what this data cannot show. "
            "Record one motion twice: what comes again is no noise"
        )
    return Remaining(**{**vars(line), "sentence": f"{text}{_beside(left, place, text)}."})


def _beside(left: Unexplained | None, place: Place | None, text: str) -> str:
    """Where more of it lies than its witness speaks of."""
    if not isinstance(left, Unnamed) or place is None or _told(place) in text:
        return ""
    return f". {_with_hint(place)}" if place.what.excess > left.share else ""


def _spring_named(joints: Sequence[int]) -> str:
    """What is the first to be thought of where something swings on."""
    if not joints:
        return ""
    named = joint_words(sorted(set(joints)))
    return f"the spring that was found in {named}, if it is other than its law has it; or else "


def _read(joint: int, variables: Sequence[str]) -> str:
    if "time" in variables:
        return "A motor or a sensor that reads less, or more, as it warms"
    if variables == (f"tau{joint + 1}",):
        return "A reading with a step, a dead band or a bend: look at how its torque is measured"
    return "A channel that takes on another's torque, or gears that share it"


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


def _with_neighbours(line: Remaining, others: Sequence[Unexplained]) -> Remaining:
    """What pulls at one joint by two angles pulls at another by the same, often too weakly to be
    sure of."""
    maps = [one for one in others if isinstance(one, Structure) and len(one.variables) > 1]
    if not maps:
        return line
    first = maps[0]
    text = f" Or it is {listed(first.variables)}, as on joint {first.joint + 1}."
    return replace(line, sentence=line.sentence + text)


def _with_outdone(line: Remaining, named: Sequence[str], share: float) -> Remaining:
    text = (
        f" What looks like {listed(named)} there ({percent(share)} of its squared error) is part "
        "of that: alone it leaves much more than a map."
    )
    return replace(line, sentence=line.sentence + text)


def _with_gain(line: Remaining, gain: Structure, found: bool) -> Remaining:
    """With what a reading would explain that is larger here and smaller there; found: beside
    findings on the joint, which leave more than that alone would."""
    where = "speed" if gain.variables[0].startswith("dq") else "angle"
    gone = (
        "that alone would leave less than what was found there"
        if found
        else f"{percent(gain.share)} would be gone"
    )
    text = (
        f" Were the joint's torque read differently from {where} to {where}, {gone}: look at how "
        "it is measured."
    )
    return replace(line, sentence=line.sentence + text)


def _size(line: Remaining, unit: str) -> str:
    if line.source is None:
        return (
            f"Joint {line.joint + 1} keeps {line.rms:.3g} {unit}; its noise floor is not known "
            "from this data"
        )
    return (
        f"Joint {line.joint + 1} keeps {line.rms:.3g} {unit}, {times(line.ratio)} its noise floor "
        f"(from {line.source})"
    )
