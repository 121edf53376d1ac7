"""``pa10d case-study``: the paper's chapter 3 on the virtual arm, joints 1-4."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, table
from pa10d.cli.commands import Subcommands, file_option
from pa10d.cli.progress import progress_line
from pa10d.cli.story import end_as_after_interrupt, seed_number, study_folder, tell

if TYPE_CHECKING:
    from pa10d.paper.results import CaseStudy


def add_commands(commands: Subcommands) -> None:
    """``case-study``."""
    parser = commands.add(
        "case-study",
        case_study,
        "the paper's chapter 3 on the virtual arm, joints 1-4",
        patient=True,
        examples=(
            "pa10d case-study --quick",
            "pa10d --data study case-study --seed 2 --report study.html",
        ),
    )
    parser.add_argument(
        "--seed", type=seed_number, default=1, metavar="N", help="which arm (default: 1)"
    )
    parser.add_argument("--quick", action="store_true", help="a short form: fewer, shorter runs")
    file_option(parser, "report", "the HTML report (default: case-study.html)", "case-study.html")


def case_study(options: argparse.Namespace) -> Answer:
    """``case-study``."""
    from pa10d.case_study import carry_out

    end_as_after_interrupt()
    began = time.monotonic()
    report = options.report.absolute()
    with study_folder(options.data) as data:
        found = carry_out(
            data, report, seed=options.seed, quick=options.quick, tell=tell,
            progress=progress_line(),
        )  # fmt: skip
    took = time.monotonic() - began
    document = {**found.document(), "report": str(report), "total_seconds": round(took, 1)}
    return Answer(document, _in_words(found, took, report))


def _in_words(found: CaseStudy, took: float, report: Path) -> str:
    fast, slow = found.following["4s"], found.following["40s"]
    head = [
        "joint", "boundary rad/s", "set A N·m", "set B N·m",
        *(f"{pace} {how}, mrad" for pace, runs in found.following.items() for how in runs),
    ]  # fmt: skip
    rows = [
        [
            f"{j + 1} {name}",
            f"{found.boundaries.values[j]:.3f}",
            f"{found.rms_set_a[j]:.3f}",
            f"{found.rms_set_b[j]:.3f}",
            *(f"{1e3 * run.rms[j]:.3f}" for runs in (fast, slow) for run in runs.values()),
        ]
        for j, name in enumerate(found.joints)
    ]
    return "\n".join(
        [
            "",
            table(head, rows),
            "",
            f"condition number {found.excitation.condition_number:.1f}, "
            f"{found.identified.inertial_base_parameters} inertial base parameters, "
            f"{'feasible' if found.identified.feasible else 'not feasible'}",
            found.answer,
            f"{took:.0f} s. Report: {report}",
        ]
    )
