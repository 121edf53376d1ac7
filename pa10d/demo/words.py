"""What the daemon answers, in the words of a story."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pa10d.common.words import listed, percent, times
from pa10d.diagnose.outcome.words import nothing
from pa10d.effects import all_effects
from pa10d.report.verdict import more_or_less, place_words
from pa10d.trajectory.kinds import KINDS

Document = Mapping[str, Any]

__all__ = ["compared_words", "fall_words", "found_words", "named", "plan_words"]


def named(finding: Document, frozen: bool = False) -> str:
    """``Stribeck friction in joint 4``."""
    kind = all_effects()[finding["effect"]]
    change = next(iter(finding["parameters"].values()))["value"] if frozen else 0.0
    return f"{more_or_less(kind, change, frozen)}{place_words(finding['joints'])}"


def compared_words(found: Document) -> str:
    """Where the model is worst, against the noise of the sensors."""
    pooled = found["pooled"]
    ratio = np.array(pooled["rms"]) / np.array(pooled["noise_floor"], dtype=float)
    known = bool(np.any(np.isfinite(ratio)))
    worst = int(np.nanargmax(ratio if known else np.array(pooled["nrmse"])))
    size = (
        f"{times(ratio[worst])} the noise of its sensors"
        if known
        else f"{percent(pooled['nrmse'][worst])} of its torque's range"
    )
    text = f"Worst is joint {worst + 1}: its error is {size}."
    if not pooled["where"]:
        return f"{text} No region stands out."
    sentence = pooled["where"][0]["sentence"]
    return f"{text} {sentence[0].upper()}{sentence[1:].removesuffix('.')}."


def _unexplained(s: Document) -> str:
    start = f"{percent(min(s['share'], 1.0))} of joint {s['joint']}'s squared error"
    if not s["depends_on"]:
        return f"{start} is no noise"
    return f"{start} depends on {' and '.join(s['depends_on'])}"


def found_words(found: Document) -> str:
    """The verdict of a diagnosis."""
    if found["verdict"] == "none":
        return nothing(found["rms"], found["noise_floor"], found["frozen"])
    if found["verdict"] == "unknown":
        places = [_unexplained(s) for s in found["unexplained"]]
        what = "has changed" if found["frozen"] else "is missing"
        return f"Something {what} that no effect of the library explains: {listed(places)}."
    verb = "What changed" if found["frozen"] else "Missing in the model"
    text = f"{verb}: {listed([named(f, found['frozen']) for f in found['findings']])}."
    sizes = [
        f"{name} = {v['value']:.3g} ± {v['std_error']:.1g} {v['unit']}"
        for name, v in found["findings"][0]["parameters"].items()
        if v.get("determined", True)
    ]
    text += f" {', '.join(sizes)}."
    if found["unexplained"]:
        text += " Something besides is left that no effect of the library explains."
    return text


def plan_words(finding: Document) -> str:
    """What a finding could be confused with, and what settles it."""
    rivals = list(dict.fromkeys(named(rival) for rival in finding["confounded_with"]))
    plan = finding["next_experiment"]
    joints = (plan.get("parameters") or {}).get("joints")
    where = f", joint {' and '.join(map(str, joints))}" if joints else ""
    title = KINDS[plan["kind"]].title
    return (
        f"{named(finding)} could also be {listed(rivals)}. The experiment that settles it: "
        f"{plan['kind']}{where} ({title[0].lower()}{title[1:]})."
    )


def fall_words(before: Sequence[float], after: Sequence[float]) -> str:
    """How far the error falls, at the joint where it falls most."""
    fall = (np.array(before) ** 2 - np.array(after) ** 2) / np.array(before) ** 2
    j = int(np.argmax(fall))
    return (
        f"The error of joint {j + 1} falls from {before[j]:.3g} to {after[j]:.3g} N·m on runs "
        "that the fit has not seen."
    )
