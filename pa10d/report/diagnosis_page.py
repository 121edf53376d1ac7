"""The report of a diagnosis: from the plot to the decision, for a person who asks why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pa10d.common.version import __version__
from pa10d.common.words import listed
from pa10d.diagnose.constants import MATERIAL_REST, MUCH_WORSE, USUAL
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.figures.diagnosis_texts import STAIRCASE
from pa10d.figures.held_out import HeldOut
from pa10d.figures.of_diagnosis import diagnosis_figures
from pa10d.judgement import first_and_last
from pa10d.report.blocks import Block, Cards, Lines, Plot, Section, Table, Text
from pa10d.report.facts import Facts, Verdict
from pa10d.report.finding_section import Asked, finding_section
from pa10d.report.near_noise import near_noise
from pa10d.report.page import page
from pa10d.report.unexplained_section import unexplained_section
from pa10d.report.verdict import finding_words, headline


@dataclass(frozen=True)
class DiagnosisSections:
    """The parts of the page, in their order."""

    verdict: Section
    findings: tuple[Section, ...]
    unexplained: tuple[Section, ...]
    rest: tuple[Section, ...]


def diagnosis_sections(found: Diagnosis, seen: HeldOut, asked: Asked) -> DiagnosisSections:
    """What there is to say of a diagnosis, for the report and the web page alike."""
    drawn = diagnosis_figures(found, seen)
    numbers = range(len(found.findings))
    return DiagnosisSections(
        _glance(found),
        tuple(finding_section(found, k, drawn["findings"][k], asked) for k in numbers),
        tuple(
            unexplained_section(found, s, figure, asked)
            for s, figure in zip(found.unexplained, drawn["unexplained"], strict=True)
        ),
        (
            _remaining(found),
            *([_staircase(found, drawn)] if found.findings else []),
            _figures(found),
            _judged(found, asked),
        ),
    )


def diagnosis_page(
    found: Diagnosis, seen: HeldOut, asked: Asked, first: tuple[Block, ...] = ()
) -> str:
    """One HTML file that opens offline; first: blocks before everything else."""
    parts = diagnosis_sections(found, seen, asked)
    question = "what has changed?" if found.frozen else "what is missing?"
    robot = found.model.robot
    return page(
        f"{asked.model}: {question}",
        f"{robot.name}, {robot.n} joints · judged on {found.judged_on}",
        [*first, parts.verdict, *parts.findings, *parts.unexplained, *parts.rest],
        f"pa10d {__version__}. SI units, torque at the joint side, joints numbered from 1.",
    )


def _glance(found: Diagnosis) -> Section:
    ratio = found.left.ratio
    cards = [
        ("effects found", str(len(found.findings)),
         listed([finding_words(f, found.frozen) for f in found.findings]) or "none is significant"),
        ("left unexplained", *_left(found)),
        ("joints near the noise", *near_noise(ratio, MATERIAL_REST, ", after all that was found")),
    ]  # fmt: skip
    warnings = [("Note:", warning) for warning in found.warnings]
    blocks: list[Block] = [Verdict(headline(found), found.verdict), Cards(cards)]
    return Section("Verdict", [*blocks, Lines(warnings)] if warnings else blocks)


def _left(found: Diagnosis) -> tuple[str, str]:
    """On how many joints more than noise is left, and what is known of it."""
    predicted = {one.joint for one in found.unexplained}
    places = predicted | {one.joint for one in found.remaining if one.material}
    if places:
        how = "motion predicts it" if predicted else "motion does not predict it"
        if predicted and len(places) > len(predicted):
            how = f"motion predicts it on {len(predicted)}"
        return (
            f"{len(places)} joint{'' if len(places) == 1 else 's'}",
            f"above the noise floor; {how}",
        )
    if all(one.material is None for one in found.remaining):
        return "–", "noise not known"
    return "nothing", "above the noise floor"


OR_MORE = f" or more than {USUAL:g} times what the joint kept on the model's own runs"


def _remaining(found: Diagnosis) -> Section:
    lines = [("", line.sentence) for line in found.remaining]
    return Section("What is left on every joint", [Lines(lines)])


def _staircase(found: Diagnosis, drawn: Mapping[str, Any]) -> Section:
    known = bool(np.all(np.isfinite(found.noise_floor)))
    plot = Plot("Error of every joint, step by step", drawn["staircase"], STAIRCASE.told(known))
    return Section("How far it brings you", [plot])


def _figures(found: Diagnosis) -> Section:
    units = [found.model.robot.torque_unit(j) for j in range(found.model.robot.n)]
    labels = [word for word, _ in found.stages]
    head = ["joint", *labels, "noise floor", "left ÷ noise", "unit"]
    rows = []
    for j, name in enumerate(found.model.robot.joint_names):
        steps = [float(errors[j]) for _, errors in found.stages]
        floor = float(found.noise_floor[j])
        known = np.isfinite(floor) and floor > 0
        rows.append([
            f"{j + 1} {name}", *(f"{v:.4g}" for v in steps), f"{floor:.4g}" if known else "unknown",
            f"{steps[-1] / floor:.2f}" if known else "–", units[j],
        ])  # fmt: skip
    note = Text(
        f"RMS error on held-out data; measured and modelled torque both low-passed at "
        f"{found.cutoff:g} Hz; samples {first_and_last(found.as_given, found.left)}. Noise floor: "
        "what a perfect model would leave; how it was found stands with each joint above.",
        muted=True,
    )
    return Section("Figures", [Table(head, rows), note])


def _judged(found: Diagnosis, asked: Asked) -> Section:
    fitted = ", ".join(dict.fromkeys(asked.fit))
    how = (
        "The model may move only as far as its own uncertainty allows; nothing is refitted."
        if found.frozen
        else "For every candidate the whole model is refitted with it, so that it gets credit only "
        "for what the model's own parameters could not have explained."
    )
    return Section(
        "What was judged on which data",
        [
            Facts(
                [
                    ("Fitted to", fitted),
                    ("Judged on", found.judged_on),
                    ("How", how),
                    (
                        "When is an effect named?",
                        "When it predicts the error of data not fitted, by more than noise of the "
                        "same colour could, counted over all effects and joints that were tried "
                        f"(1 % false alarms per search){OR_MORE if found.frozen else ''}, and "
                        "leaves the joints no worse on the whole, and none significantly so by "
                        f"more than {MUCH_WORSE:.0%}.",
                    ),
                    ("Low-pass", f"{found.cutoff:g} Hz, zero-phase, on both sides alike"),
                ]
            )
        ],
    )
