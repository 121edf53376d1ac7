"""What came of the steps of an investigation, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.common.words import listed, percent, times
from pa10d.compare.comparison import RunScores
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.diagnose.outcome.words import nothing
from pa10d.effects import all_effects
from pa10d.identify.summary import FitSummary
from pa10d.investigation.results import (
    LastWord,
    NamedEffect,
    Searched,
    Size,
    StoredAs,
    Structured,
)
from pa10d.report.verdict import more_or_less, place_words
from pa10d.trajectory.kinds import KINDS

RISE = 0.1  # of the squared error that is worth a word


def named(finding: NamedEffect, frozen: bool = False) -> str:
    """``Stribeck friction in joint 4``."""
    kind = all_effects()[finding.effect]
    change = next(iter(finding.parameters.values())).value if frozen else 0.0
    return f"{more_or_less(kind, change, frozen)}{place_words(finding.joints)}"


def compared_words(pooled: RunScores) -> str:
    """Where the model is worst, against the noise of the sensors."""
    scores = pooled.scores
    ratio = scores.rms / pooled.noise_floor
    known = bool(np.any(np.isfinite(ratio)))
    worst = int(np.nanargmax(ratio if known else scores.nrmse))
    size = (
        f"{times(ratio[worst])} the noise of its sensors"
        if known
        else f"{percent(scores.nrmse[worst])} of its torque's range"
    )
    text = f"Worst is joint {worst + 1}: its error is {size}."
    if not pooled.where:
        return f"{text} No region stands out."
    sentence = pooled.where[0].sentence
    return f"{text} {sentence[0].upper()}{sentence[1:].removesuffix('.')}."


def _unexplained(s: Structured) -> str:
    start = f"{percent(min(s.share, 1.0))} of joint {s.joint}'s squared error"
    if not s.depends_on:
        return f"{start} is more than the noise that this data shows"
    return f"{start} depends on {' and '.join(s.depends_on)}"


def found_words(found: Searched) -> str:
    """The verdict of a diagnosis."""
    if found.verdict == "none":
        told = found.rms_with_reversals
        reversals = None if told is None else np.array(told, dtype=float)
        return nothing(
            found.rms,
            np.array(found.noise_floor, dtype=float),
            found.frozen,
            found.rms_as_given,
            reversals,
        )
    if found.verdict == "unknown":
        places = [_unexplained(s) for s in found.unexplained]
        what = "has changed" if found.frozen else "is missing"
        return f"Something {what} that no effect of the library explains: {listed(places)}."
    verb = "What changed" if found.frozen else "Missing in the model"
    text = f"{verb}: {listed([named(f, found.frozen) for f in found.findings])}."
    for finding in found.findings:
        sizes = [_sized(*one) for one in finding.parameters.items() if one[1].determined]
        whose = f"{named(finding, found.frozen)}: " if len(found.findings) > 1 else ""
        text += f" {whose}{', '.join(sizes)}." if sizes else ""
    if found.unexplained:
        text += " Something besides is left that no effect of the library explains."
    return text


def _sized(name: str, size: Size) -> str:
    """``F = 1.12 ± 0.06 N·m``; what was chosen, not fitted, has no error: ``ratio = 1``."""
    error = f" ± {size.std_error:.1g}" if size.std_error else ""
    return f"{name} = {size.value:.3g}{error} {size.unit}".removesuffix(" 1")


def identified_words(found: FitSummary) -> str:
    """What the textbook fit is like."""
    condition = found.condition_number
    text = f"{found.base_parameters} base parameters"
    if condition is not None:
        text += f", condition number {condition:.3g}"
    text += f", fitted below {found.cutoff_hz:.3g} Hz."
    if not found.feasible:
        text += " No bodies that can exist are known for it."
    return " ".join([text, *(f"{w[0].upper()}{w[1:].rstrip('.')}." for w in found.warnings)])


def doubt_words(finding: NamedEffect, plan: NextExperiment) -> str:
    """What a finding could be confused with, and what settles it."""
    rivals = dict.fromkeys(
        f"{all_effects()[rival.effect].named}{place_words(rival.joints)}"
        for rival in finding.confounded_with
    )
    joints = plan.parameters.get("joints")
    where = f", joint {' and '.join(map(str, joints))}" if joints else ""
    title = KINDS[plan.kind].title
    return (
        f"{named(finding)} could also be {listed(list(rivals))}. The experiment that settles it: "
        f"{plan.kind}{where} ({title[0].lower()}{title[1:]})."
    )


def added_words(versions: Sequence[StoredAs], findings: Sequence[NamedEffect], frozen: bool) -> str:
    """Which versions have what."""
    made = [f"{v.name} has {named(f, frozen)}" for v, f in zip(versions, findings, strict=True)]
    return f"{listed(made)}; the model before stays as it is."


def fall_words(judged: LastWord) -> str:
    """How far the error fell, at the joint where it fell most; what rose is not left out."""
    before, after = np.array(judged.before), np.array(judged.after)
    where = f"on runs that {judged.seen}"
    if len(judged.models) == 1:
        return f"{judged.models[0]} is judged {where}; nothing was added to it."
    fall = (before**2 - after**2) / np.maximum(before**2, 1e-300)
    best, worst = int(np.argmax(fall)), int(np.argmin(fall))

    def sizes(j: int) -> str:
        return f"from {before[j]:.3g} to {after[j]:.3g} {judged.unit(j)}"

    text = (
        f"The error of joint {best + 1} falls {sizes(best)} {where}."
        if fall[best] > 0
        else f"No joint's error falls {where}."
    )
    if fall[worst] < -RISE:
        text += f" That of joint {worst + 1} rises {sizes(worst)}."
    return text
