"""A finding in one sentence that a technician understands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.common.words import joint_words, listed, percent, rounded, times
from pa10d.diagnose.constants import BEYOND_NOISE, MATERIAL_GAIN, MATERIAL_REST, OWN_SHARE
from pa10d.diagnose.outcome.diagnosis import Confusion, Diagnosis
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.effects import Effect, Value, effect
from pa10d.model import Term

Array = NDArray[np.float64]


def sentence(
    term: Term,
    before: Array,
    after: Array,
    size: Value,
    confusions: Sequence[Confusion],
    frozen: bool,
    others: Sequence[int] = (),
    sized: bool = True,
    beside: tuple[Array, Array] | None = None,
) -> str:
    """What and where, how large, and what it takes away of the joint that it helps most.

    before, after: (n,) N·m held out; frozen: the model stayed as it was, so something changed;
    others: joints (0-based) on which the same effect is not named; sized: its coefficients are
    other than nothing by their own errors; beside: (n,) N·m each that all that was found leaves
    without it and with it
    """
    worst, own = helped_most(term, before, after)
    late = beside is not None and after[worst] > (1.0 - MATERIAL_GAIN) * before[worst]
    if late and beside is not None:  # what came after it made room for it
        before, after = beside
        worst, own = helped_most(term, before, after)
    share = percent(1.0 - (after[worst] / max(before[worst], 1e-300)) ** 2)
    about = f"about {rounded(size.value, 2)} {size.unit}"
    if frozen:
        said = changed(term, about)
    else:
        lacks = float(np.sqrt(max(before[worst] ** 2 - after[worst] ** 2, 0.0)))
        said = missing(term, about + _lacking(size, lacks if own == 1 else None))
    when = ", beside what follows: when it came, hardly any was" if late else ""
    text = f"{said}; with it {share} of joint {worst + 1}'s squared error is gone{when}."
    if not frozen and others and term.effect.only_against_others:
        text += f" {term.effect.only_against_others.format(others=_weighing(others))}."
    if frozen and term.effect.question == "missing" and not term.effect.also_changes:
        text += " Or it was there all along, where the model's own runs do not show it."
    if sized and term.effect.below_zero and term.coefficients[0] < 0.0 and not frozen:
        text += f" {term.effect.below_zero}."
    if not sized:
        text += (
            " How large it is, this data hardly says: other terms, or what the model still lacks, "
            "can stand in for it."
        )
    if confusions:
        rivals = sorted({_other(term, c) for c in confusions})
        text += f" This data cannot yet tell it from {listed(rivals, 'or')}."
    return text


def _weighing(others: Sequence[int]) -> str:
    """Of several no one knows who it is: a wrist may read what it likes."""
    alike = ", each as far as it weighs the same bodies" if len(others) > 1 else ""
    return f"{joint_words(others)}{alike}"


def helped_most(term: Term, before: Array, after: Array) -> tuple[int, int]:
    """The joint (0-based) by whose figures an effect is told, and among how many that speak for it:
    its own, unless its torque shows on another one."""
    told = np.arange(len(before))[term.effect.speaks_on(term.joints)]
    gone = 1.0 - (after / np.maximum(before, 1e-300)) ** 2
    best = max(term.joints, key=lambda j: gone[j], default=None)
    if best is None or gone[best] < OWN_SHARE:
        best = told[np.argmax(gone[told])]
    return int(best), len(told)


def _other(term: Term, rival: Confusion) -> str:
    """A rival of a finding, with its place where only that differs."""
    if rival.effect != term.effect_id:
        return effect(rival.effect).named
    joints = listed([str(j + 1) for j in rival.joints])
    return f"one of another size on joint{'s' if len(rival.joints) > 1 else ''} {joints}"


def nothing(
    rms: ArrayLike,
    noise_floor: ArrayLike,
    frozen: bool,
    as_given: ArrayLike | None = None,
    with_reversals: ArrayLike | None = None,
    hardly_known: Sequence[int] = (),
) -> str:
    """The verdict where nothing was found, (n,) N·m each; it owns up to errors far above noise, to
    those of the model as it was given that a new fit of the same terms took away, to those near
    reversals, which are not judged, and to joints (0-based) whose noise is hardly known."""
    floor = np.array([np.nan if f is None else f for f in np.atleast_1d(noise_floor)], dtype=float)
    floor = np.where(floor > 0.0, floor, np.nan)  # no floor, no claim
    ratio = np.asarray(rms) / floor
    large = np.flatnonzero(ratio > MATERIAL_REST)
    first = "Nothing has changed" if frozen else "Nothing is missing"
    if not len(large) and not np.all(np.isfinite(ratio)):
        asked = "has changed" if frozen else "is missing"
        return (
            f"Nothing that was looked for shows itself; whether something {asked} this data cannot "
            "say, for it does not show how strong the noise is. "
            "Record one motion twice: what differs is noise, and what comes again is none."
        )
    if not len(large):
        said = f"{first}: what the model leaves over on new data is measurement noise."
        if hardly_known:
            said = (
                f"{first} that shows: what the model leaves over on new data is measurement noise, "
                f"but of the noise of {joint_words(hardly_known)} this data says next to nothing."
            )
        said += _gone_by_refit(ratio if as_given is None else np.asarray(as_given) / floor)
        return said + _left_out(
            ratio if with_reversals is None else np.asarray(with_reversals) / floor
        )
    joints = listed([str(j + 1) for j in large])
    keeps = "s {} keep" if len(large) > 1 else " {} keeps"
    if np.max(ratio[large]) > BEYOND_NOISE:
        asked = "has changed" if frozen else "is missing"
        since = "" if frozen else "; where the arm may be another since, ask what has changed"
        return (
            f"This data cannot say whether something {asked}: joint{keeps.format(joints)} up to "
            f"{times(np.max(ratio[large]))} the noise, but nothing that was tried explains it "
            "clearly enough to be named, and it may be slow noise. Record more, or the same motion "
            f"twice: what repeats is no noise{since}."
        )
    return (
        f"{first} that this data can show. Joint{keeps.format(joints)} up to "
        f"{times(np.max(ratio[large]))} the noise, but nothing that was tried explains it "
        "clearly enough. Record more, or the same motion twice: what repeats is no noise."
    )


def _gone_by_refit(ratio: Array) -> str:
    """What the given model left, (n,) times the floor, where that was more than noise."""
    found = _most_of(ratio)
    return found and (
        " That is the model fitted anew, clear of reversals; as it was given, it keeps up to "
        f"{found}: its values, not its terms, are off."
    )


def _left_out(ratio: Array) -> str:
    """What is left where reversals count, too, (n,) times the floor, if that is more than noise."""
    found = _most_of(ratio)
    return found and (
        f" Reversals are left out of that; with them, there is up to {found}: sticking, friction "
        "at low speed that the model lacks, or turning round faster than the samples follow. "
        "Slow, steady motion would tell."
    )


def _most_of(ratio: Array) -> str:
    """``3 times the noise on joints 1 and 2``: those with more than noise, or nothing."""
    large = np.flatnonzero(ratio > MATERIAL_REST)
    if not len(large):
        return ""
    joints = listed([str(j + 1) for j in large])
    return f"{times(np.max(ratio[large]))} the noise on joint{'s' * (len(large) > 1)} {joints}"


def missing(term: Term, size: str) -> str:
    """``Joint 4 shows Stribeck friction (extra friction at low speed): … that the model lacks``."""
    verb = "show" if len(term.joints) > 1 else "shows"
    return f"{_place(term)} {verb} {_explained(term.effect)}: {size}"


def _lacking(size: Value, lacks: float | None) -> str:
    """How much of it the model is without: its own terms stand in for the rest. None: it acts on
    several joints, whose torques are no one number."""
    if lacks is None:
        return " where it acts most"
    part = rounded(lacks, 2)
    if part == rounded(size.value, 2):
        return " that the model lacks"
    if lacks > size.value:  # where it is missing, what stands in for it bends the rest
        return f", and the model without it lacks {part} {size.unit}"
    return f", of which the model lacks {part} {size.unit}"


def changed(term: Term, size: str) -> str:
    """``Joint 4 now has more Coulomb friction …`` than when the model was made."""
    kind, verb = term.effect, "have" if len(term.joints) > 1 else "has"
    if kind.question == "textbook":
        way = "more" if term.coefficients[0] > 0 else "less"
        return f"{_place(term)} now {verb} {way} {_explained(kind)} than its model: {size}"
    return f"{_place(term)} now {verb} {_explained(kind)}: {size} that its model does not know"


def reason(kind: Effect, other: Effect) -> str:
    """Why this data cannot tell one from the other."""
    return kind.confounders.get(
        other.id, "on this data both ask for nearly the same torque, and leave as small an error"
    )


def _explained(kind: Effect) -> str:
    return f"{kind.named} ({kind.plainly})" if kind.plainly else kind.named


def _place(term: Term) -> str:
    joints = listed([str(j + 1) for j in term.joints])
    return f"Joint{'s' if len(term.joints) > 1 else ''} {joints}" if joints else "The arm"


def headline(found: Diagnosis) -> str:
    """The answer in its first sentence or two. The verdict alone does not tell an arm that lacks
    nothing from one of which this data cannot say."""
    if found.verdict == "none":
        return none_found(found)
    if found.verdict == "unknown":
        return f"{unexplained(found)}."
    return f"{found.heading}: {', '.join(f.term.label for f in found.findings)}."


def in_json(found: Diagnosis) -> JsonObject:
    """JSON of ``diagnose``, with its first sentence."""
    return {**found.document(), "headline": headline(found)}


def none_found(found: Diagnosis) -> str:
    """The verdict where nothing was found; of one suspicion it says nothing of all others."""
    if found.only and found.stood:
        return (
            f"Whether {found.only} came this data cannot say: {found.stood}. Nothing else was "
            "looked for."
        )
    if found.only and found.absorbed:
        return (
            f"This data cannot tell {found.only} from what the model has already, bodies among it; "
            "nothing else was looked for."
        )
    if found.only:
        return f"This data does not show {found.only}; nothing else was looked for."
    if found.stood:
        return f"Whether something has changed this data cannot say: {found.stood}."
    given = found.rms if found.beside else found.as_given.rms  # else its values were off
    hardly = np.flatnonzero(found.left.floor.hardly_known).tolist()
    said = nothing(found.rms, found.noise_floor, found.frozen, given, found.with_reversals, hardly)
    if found.knocked:
        leaves = "leaves" if len(found.knocked) == 1 else "leave"
        said += f" Most of what {joint_words(found.knocked)} {leaves} lies in a few moments."
    if found.above_band:
        joints = joint_words(sorted(found.above_band))
        said += f" That is what the low-pass lets through: above it there is more on {joints}."
    return said


def unexplained(found: Diagnosis) -> str:
    """What to say where something is left that was not found, without its end."""
    if found.only:
        return f"Something is left that {found.only} does not explain; nothing else was looked for"
    named = {one.joint for one in found.unexplained}
    if found.contradicted and named == {one.joint for one in found.contradicted}:
        one = found.contradicted[0]
        came = one.came or "something came or went"
        moment = f"{came} {one.at:.1f} s into {listed(one.runs)}" if one.at else ""
        asks = one.words if one.all_along else moment or "they ask for different parameters"
        return f"{one.who[0].upper()}{one.who[1:]}: {asks}"
    if found.misplaced and named == {one.joint for one in found.misplaced}:
        return (
            "No effect of the library, but an arm that is not as its URDF says explains it "
            f"({found.misplaced[0].words})"
        )
    if found.stood:
        return f"Something has changed, or was never known: {found.stood}"
    unseen = [u for u in found.unexplained if isinstance(u, Unnamed) and u.witness == "unseen"]
    if unseen and named == {u.joint for u in unseen} and not found.frozen:
        laws = listed(list(dict.fromkeys(f"{u.law} in joint {u.joint + 1}" for u in unseen)))
        return f"The fitted runs ask for {laws}, and those held out do not go where it acts"
    if not found.frozen:
        return "Something is missing that no effect of the library explains"
    if named <= set(found.lacked):
        return "The model keeps an error that it had before: something is missing, not changed"
    return "Something has changed that no effect of the library explains"
