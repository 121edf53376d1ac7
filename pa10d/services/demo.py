"""The demo: an arm hides an effect; record, identify, compare, diagnose, add; then the truth.

The diagnosis sees recordings in the store and nothing else. It may be wrong, and then the story
says so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pa10d.diagnose.outcome import Diagnosis
from pa10d.effects import all_effects
from pa10d.report.blocks import Section, Text
from pa10d.report.facts import Facts, Verdict
from pa10d.report.verdict import answer, doubt_words, finding_words, gain_words, listed
from pa10d.services.demo_arm import (
    FIT,
    REFERENCE,
    VALIDATE,
    Hidden,
    hide,
    names,
    record,
    store_runs,
)
from pa10d.services.diagnoses import diagnose_runs, store_versions, write_diagnosis_report
from pa10d.services.library import Library
from pa10d.services.models import compare_runs, identify_runs
from pa10d.services.robots import load_robot

Tell = Callable[[str], None]
Progress = Callable[[float, str], None]


@dataclass(frozen=True)
class Told:
    """How the story ended. right: None where nobody knows the truth."""

    hidden: Hidden
    diagnosis: Diagnosis
    right: bool | None
    report: Path
    seed: int
    models: tuple[str, ...]

    def document(self) -> dict[str, Any]:
        """JSON of ``demo``."""
        findings = self.diagnosis.findings
        found = findings[0].term if findings else None
        found_joints = [j + 1 for j in found.joints] if found else []
        # what a foreign plant hides, and where, is not known here: then it is the answer's joint
        joints = list(self.hidden.joints) if self.hidden.effects else found_joints
        return {
            "hidden": self.hidden.name,
            "joint": joints[0] if joints else None,
            "found": found.effect_id if found else None,
            "rms_before": self.diagnosis.rms,
            "rms_after": self.diagnosis.versions[-1].held_out["held out"],
            "report": str(self.report),
            "right": self.right,
            "hidden_joints": list(self.hidden.joints),
            "found_joints": found_joints,
            "parameters": self.hidden.effects,
            "seed": self.seed,
            "verdict": self.diagnosis.verdict,
            "findings": [finding.document() for finding in findings],
            "unexplained": self.diagnosis.document()["unexplained"],
            "noise_floor": self.diagnosis.noise_floor,
            "models": list(self.models),
        }


def play(
    library: Library,
    profile_name: str,
    *,
    asked: str | None,
    seed: int,
    report: Path,
    tell: Tell,
    progress: Progress,
    seconds: float = 40.0,
    noise: str = "white",
) -> Told:
    """From a hidden effect to the report; tell: a line of the story."""
    profile, robot = load_robot(profile_name)
    hidden = hide(asked, seed, profile)
    prefix = f"demo{seed}-"
    tell(
        f"1. A simulated {robot.name} with {robot.n} joints; its masses and friction are drawn "
        f"anew (seed {seed}). {_secret(hidden)}"
    )

    runs = record(hidden, seed, noise, profile, seconds)
    store_runs(library, runs, robot, profile, prefix)
    tell(
        f"2. It moves, and is recorded: {len(runs)} runs of {seconds:g} s, angles and torques only."
    )
    tell("   Two runs to fit the model to, two others to judge it by.")

    fit, validate = names(prefix, FIT), names(prefix, VALIDATE)
    learnt = fit
    if hidden.changed:
        learnt = names(prefix, REFERENCE)
        tell("   Two more are from before: this story asks what has changed since.")
    model = f"{prefix}m0"
    identify_runs(library, learnt, str(profile.path), name=model, replace=True)
    tell("3. The textbook model is fitted: rigid bodies, rotors, Coulomb and viscous friction.")

    compared = compare_runs(library, model, validate)
    pooled = compared.comparison.pooled
    ratio = pooled.scores.rms / pooled.noise_floor
    worst = int(ratio.argmax())
    place = f" {_sentence(pooled.where[0].sentence)}" if pooled.where else " No region stands out."
    tell(
        "4. Is the model right? It is judged by the runs that the fit has not seen. Worst is joint "
        f"{worst + 1}: its error is {ratio[worst]:.1f} times the noise of its sensors.{place}"
    )

    what = "has changed" if hidden.changed else "is missing"
    tell(f"5. Which physical effect {what}? Every effect of the library is tried on every joint.")
    found = diagnose_runs(library, model, fit, validate, frozen=hidden.changed, progress=progress)
    tell(f"   {answer(found)}")
    stored = store_versions(library, model, found, name=f"{prefix}m1", replace_model=True)
    if found.findings:
        doubt = doubt_words(found)
        if doubt:
            tell(f"   {doubt} The report has it.")
        tell(
            f"6. It is added as a new version of the model; the old one stays. {gain_words(found)}"
        )
    else:
        tell("6. There is nothing to add.")

    right = judged(hidden, found)
    truth = verdict_on(hidden, found, right)
    tell(f"7. Now the simulator tells what was hidden: {hidden.in_words()}.")
    tell(f"   {truth}")
    path = write_diagnosis_report(
        library, found, report, model=model, fit=fit, validate=validate,
        first=(_story(hidden, found, truth, seed, right),),
    )  # fmt: skip
    tell(f"8. Everything with plots and words: {path}")
    made = (model, *(info.name for info in stored))
    return Told(hidden, found, right, path, seed, made)


def judged(hidden: Hidden, found: Diagnosis) -> bool | None:
    """Is the first finding what was hidden, joint included? None: nobody knows."""
    if hidden.foreign:
        return None
    if hidden.name is None:
        return found.verdict == "none"
    if hidden.name not in all_effects():
        return not found.findings and bool(
            {s.joint + 1 for s in found.unexplained} & set(hidden.joints)
        )
    if not found.findings:
        return False
    first = found.findings[0].term
    return first.effect_id == hidden.name and sorted(j + 1 for j in first.joints) == sorted(
        hidden.joints
    )


def verdict_on(hidden: Hidden, found: Diagnosis, right: bool | None) -> str:
    """The answer against the truth, in a sentence."""
    if right is None:
        return "What the plant hides is known to whoever wrote it."
    if right and hidden.name is None:
        return "The diagnosis was right to find nothing."
    if right and hidden.name not in all_effects():
        return "No effect of the library is like that; the diagnosis said so, and named the joint."
    if right:
        more = len(found.findings) - 1
        also = f" (It named {more} more, which are not there.)" if more else ""
        return f"The diagnosis was right.{also}"
    named = listed([finding_words(f) for f in found.findings]) or "nothing that it has a name for"
    if any(f.term.effect_id == hidden.name for f in found.findings[1:]):
        return f"The diagnosis was half right: it named {named}, the true one not first."
    text = f"The diagnosis was wrong: it named {named}."
    if any(c.effect == hidden.name for f in found.findings for c in f.confounded_with):
        text += " It did say that this data cannot tell the two apart."
    return text


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:].removesuffix('.')}."


def _secret(hidden: Hidden) -> str:
    if hidden.foreign:
        return "The profile brings its plant; what that hides, nobody here knows."
    return "Only the simulator knows whether and what it hides."


def _story(hidden: Hidden, found: Diagnosis, truth: str, seed: int, right: bool | None) -> Section:
    kind = "none" if right else "missing"
    words = ", ".join(finding_words(f) for f in found.findings) or f"verdict '{found.verdict}'"
    intro = Text(
        "A simulated arm moved and was recorded. A textbook model was fitted to its angles and "
        "torques, and diagnosed by them alone; afterwards the simulator told what it had hidden."
    )
    facts = Facts(
        [
            ("Hidden", hidden.in_words()),
            ("Found", words),
            ("To see it again", f"pa10d demo --seed {seed}"),
        ]
    )
    return Section("The story", [intro, facts, Verdict(truth, kind)])
