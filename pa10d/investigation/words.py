"""What came of the steps of an investigation, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.common.words import counted, listed, percent, rounded, sentence, times
from pa10d.compare.comparison import RunScores
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.dynamics import Robot
from pa10d.effects import Value, all_effects
from pa10d.identify.summary import FitSummary
from pa10d.investigation.results import LastWord, NamedEffect, StoredAs
from pa10d.report.verdict import answer, finding_words, more_or_less, place_words
from pa10d.trajectory.kinds import KINDS

Array = NDArray[np.float64]

RISE = 0.1  # of the squared error that is worth a word


def units_of(judged: JsonObject) -> str:
    """``N or N·m``: of a last word's errors, for the head of a table."""
    return " or ".join(sorted({*(judged.get("units") or ["N·m"])}))


def named(finding: NamedEffect, frozen: bool = False) -> str:
    """``Stribeck friction in joint 4``."""
    kind = all_effects()[finding.effect]
    change = next(iter(finding.parameters.values())).value if frozen else 0.0
    return f"{more_or_less(kind, change, frozen)}{place_words(finding.joints)}"


def judged_where(on: str, cutoff: float, mask: str) -> str:
    """``valid_a; low-pass 12 Hz, in motion, clear of reversals``; ``on`` in words, or ""."""
    return f"{on}{'; ' if on else ''}low-pass {cutoff:.4g} Hz, {mask}"


def compared_words(pooled: RunScores, model: str) -> str:
    """Where the model is worst, against the noise as far as this model shows it: one that lacks
    less, and is not fitted yet, may show less noise in the same runs."""
    scores = pooled.scores
    ratio = scores.rms / pooled.noise_floor
    known = bool(np.any(np.isfinite(ratio)))
    worst = int(np.nanargmax(ratio if known else scores.nrmse))
    size = (
        f"{times(ratio[worst])} the noise, as far as {model} shows it"
        if known
        else f"{percent(scores.nrmse[worst])} of its torque's range"
    )
    text = f"Worst is joint {worst + 1}: its error is {size}."
    if not pooled.where:
        return f"{text} No region stands out."
    return f"{text} {sentence(pooled.where[0].sentence)}"


def found_words(found: Diagnosis) -> str:
    """The verdict of a diagnosis, how large what it found is, and on what it was judged."""
    sizes = ""
    for finding in found.findings:
        known = [_sized(*one) for one in finding.parameters.items() if one[1].determined]
        whose = f"{finding_words(finding, found.frozen)}: " if len(found.findings) > 1 else ""
        sizes += f" {whose}{', '.join(known)}." if known else ""
    on = judged_where(found.judged_on, found.cutoff, found.left.mask)
    return f"{answer(found, sizes)} Judged on {on}."


def _sized(name: str, size: Value) -> str:
    """``F = 1.12 ± 0.06 N·m``; what was chosen, not fitted, has no error but a meaning."""
    error = f" ± {rounded(size.std_error, 1)}" if size.std_error else ""
    return f"{name} = {rounded(size.value, 3)}{error}{size.unit_after}{size.meaning}"


def left_words(
    left: Mapping[int, float], ratio: Array, pooled: RunScores, robot: Robot
) -> list[str]:
    """Of joints (0-based, and what each keeps) where that lies: more may show on fresh motion than
    on what a search has judged by. ratio: (n,) times the noise."""
    said = []
    for j, error in left.items():
        text = (
            f"Joint {j + 1} keeps {rounded(error, 3)} {robot.torque_unit(j)} there, "
            f"{times(ratio[j])} its noise floor."
        )
        where = [place.sentence for place in pooled.where if place.joint == j]
        said.append(f"{text} {where[0].removesuffix('.')}." if where else text)
    return said


def identified_words(found: FitSummary) -> str:
    """What the textbook fit is like."""
    condition = found.condition_number
    text = f"{found.base_parameters} base parameters"
    if condition is not None:
        text += f", condition number {condition:.3g}"
    text += f", fitted below {found.cutoff_hz:.3g} Hz."
    if not found.feasible:
        text += " No bodies that can exist are known for it."
    if found.warnings:
        known = counted(len(found.warnings), "note")
        text += f" {known} on it: with the model, and in the report."
    return text


def fit_notes(found: FitSummary) -> list[str]:
    """What there is to be known of a fit, the gravest first."""
    return [sentence(warning) for warning in found.warnings]


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
    there = judged_where(listed(judged.run_names), judged.cutoff_hz, judged.mask)
    where = f"on runs that {judged.seen} ({there})"
    if len(judged.models) == 1:
        text = f"{judged.models[0]} is judged {where}; nothing was added to it."
        return " ".join([text, *judged.left])
    fall = (before**2 - after**2) / np.maximum(before**2, 1e-300)
    asked = [j for j in range(len(fall)) if j + 1 not in judged.hidden]
    if not asked:
        return f"No joint's torque is known {where}: their errors say nothing."
    best, worst = max(asked, key=lambda j: fall[j]), min(asked, key=lambda j: fall[j])

    def sizes(j: int) -> str:
        return f"from {rounded(before[j], 3)} to {rounded(after[j], 3)} {judged.unit(j)}"

    text = (
        f"The error of joint {best + 1} falls {sizes(best)} {where}."
        if fall[best] > 0
        else f"No joint's error falls {where}."
    )
    if fall[worst] < -RISE:
        text += f" That of joint {worst + 1} rises {sizes(worst)}."
    return " ".join([text, *judged.left])
