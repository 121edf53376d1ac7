"""One finding, from the plot to the decision."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pa10d.common.words import listed, percent, rounded
from pa10d.diagnose.constants import SEARCH_LEVEL
from pa10d.diagnose.outcome.diagnosis import Diagnosis, Finding
from pa10d.effects import all_effects
from pa10d.figures.diagnosis_texts import BEFORE_AFTER, COURSE, EVIDENCE
from pa10d.figures.of_diagnosis import OVER_TIME, shown_joint
from pa10d.figures.texts import Reading
from pa10d.report.blocks import Block, Cards, Plot, Section, Table, Text
from pa10d.report.facts import Command, Facts
from pa10d.report.verdict import finding_words, place, removed


@dataclass(frozen=True)
class Asked:
    """What was diagnosed, by the names under which it is stored."""

    model: str
    fit: Sequence[str]
    validate: Sequence[str] = ()
    profile: str = "PROFILE"


def finding_section(found: Diagnosis, k: int, drawn: Mapping[str, Any], asked: Asked) -> Section:
    """The card of findings[k]; drawn: its entry of diagnosis_figures."""
    finding, joint = found.findings[k], shown_joint(found, k)
    share = removed(finding, joint)
    title = finding_words(finding, found.frozen)
    known = bool(np.isfinite(found.noise_floor[joint]))
    blocks: list[Block] = [
        Text(finding.sentence),
        Cards(_cards(finding, joint, share, found.model.robot.torque_unit(joint))),
        Plot("Why we think so", drawn["evidence"], _reading(drawn["evidence"]).told(known)),
        Facts(_facts(found, finding)),
        *_settle(finding),
        _parameters(finding),
        Plot("What it does to every joint", drawn["before_after"], BEFORE_AFTER.told(known)),
        _decision(found, k, asked),
    ]
    mark = f"{percent(share)} of joint {joint + 1}'s squared error is gone"
    return Section(f"{k + 1}. {title[0].upper()}{title[1:]}", blocks, mark)


def _reading(evidence: Mapping[str, Any]) -> Reading:
    return COURSE if next(iter(evidence)) == OVER_TIME else EVIDENCE


def _cards(finding: Finding, joint: int, share: float, unit: str) -> list[tuple[str, str, str]]:
    size, before, after = finding.size, finding.rms_before[joint], finding.rms_after[joint]
    where = place(finding).removeprefix(" in ").removeprefix(" between ") or "the whole arm"
    return [
        ("where", where, finding.term.effect.title),
        (
            "size of the effect",
            f"{rounded(size.value, 3)} ± {rounded(size.std_error, 1)} {unit}",
            "RMS where it acts",
        ),
        (
            f"error of joint {joint + 1}",
            f"{rounded(before, 3)} → {rounded(after, 3)} {unit}",
            "on data not fitted",
        ),
        ("squared error removed", percent(share), f"joint {joint + 1}, on data not fitted"),
    ]


def _facts(found: Diagnosis, finding: Finding) -> list[tuple[str, str]]:
    kind = finding.term.effect
    rivals = [
        f"{all_effects()[c.effect].title}{_at(c.joints)}: {c.why}" for c in finding.confounded_with
    ]
    known = [f"{all_effects()[i].title} ({why})" for i, why in kind.confounders.items()
             if i in all_effects()]  # fmt: skip
    return [
        ("What is that?", kind.meaning),
        ("As an equation", kind.equation),
        ("What is it known by?", kind.signature),
        (
            "Could it be chance?",
            f"{_by_chance(finding)} The new data show {finding.slope:.2f} times what the fit "
            "predicted; a real effect shows 1, chance 0.",
        ),
        (
            "Could it be something else?",
            "On this data, yes: " + "; ".join(rivals) + "."
            if rivals
            else "No other effect of the library explains this data as well.",
        ),
        ("Easily confused with", "; ".join(known) + "." if known else ""),
        ("Which experiment shows it best?", kind.experiment),
        ("What can be done about it?", kind.remedy),
        (
            "What does 'changed' mean?",
            "The model was not fitted anew to these runs: what is reported is the difference to "
            "the arm as it was when the model was identified."
            if found.frozen and not finding.was_there
            else "",
        ),
    ]


def _by_chance(finding: Finding) -> str:
    if finding.certain and finding.p_value >= SEARCH_LEVEL:
        return (
            f"Noise as slow and large as it likes may look so ({finding.p_value:.2g}), but it "
            "takes more than twice what the joint kept on the model's own runs."
        )
    p = "less than 1 in a million" if finding.p_value < 1e-6 else f"{finding.p_value:.2g}"
    return (
        f"The probability that noise alone looks like this, over everything that was tried, is {p}."
    )


def _settle(finding: Finding) -> list[Block]:
    if finding.next_experiment is None:
        return []
    plan = finding.next_experiment
    says = "The experiment that would settle the doubt"
    if plan.apart is not None:
        says += f" (the two explanations should then be {plan.apart:.0f} standard errors apart)"
    return [Command(says + ":", [plan.command])]


def _parameters(finding: Finding) -> Table:
    rows = []
    for name, v in finding.parameters.items():
        known = v.std_error > 0 and v.determined
        low, high = v.value - 1.96 * v.std_error, v.value + 1.96 * v.std_error
        rows.append(
            [
                name, rounded(v.value, 4) if v.determined and not v.means else str(v),
                f"± {rounded(v.std_error, 2)}" if known else "–",
                f"{rounded(low, 4)} … {rounded(high, 4)}" if known else "–",
                "" if v.unit == "1" else v.unit,
            ]
        )  # fmt: skip
    return Table(["parameter", "value", "standard error", "95 % interval", "unit"], rows)


def _decision(found: Diagnosis, k: int, asked: Asked) -> Block:
    earlier = f"{asked.model}.{k}" if k else asked.model
    term = found.findings[k].term
    joints = f" --joint {' '.join(str(j + 1) for j in term.joints)}" if term.joints else ""
    add = (
        f"pa10d add {earlier} {term.effect_id}{joints} --fit {' '.join(asked.fit)} "
        f"--name {asked.model}.{k + 1}"
    )
    if not found.frozen or found.findings[k].was_there:
        return Command("To add it (the model that you have stays as it is):", [add])
    new = f"pa10d identify {' '.join(asked.fit)} --profile {asked.profile} --name NEW"
    says = (
        "The model is of the arm as it was. Undo the change as said above; or, if it is to stay, "
    )
    if term.effect.question == "changed":
        return Command(f"{says}add it to the model, or identify the arm as it is now:", [add, new])
    return Command(f"{says}identify the arm as it is now:", [new])


def _at(joints: Sequence[int]) -> str:
    return f" in joint {listed([str(j + 1) for j in joints])}" if joints else ""
