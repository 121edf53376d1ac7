"""Attacks that tests make: run as often as asked for, counted, and their logs kept."""

from __future__ import annotations

import ast
import os
import statistics
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from attacks.target import Effort, Figures

ROOT = Path(__file__).resolve().parents[2]
COUNTED = (
    "requests",
    "files",
    "refused",
    "sequences",
    "steps",
    "longest_cycles_outside",
)  # what tests say that they tried
LONGEST = 4 * 3600  # s for one test, which may be thousands of trials on a machine that is shared
SHOWN = 160  # characters of a failure's first line


@dataclass
class Tally:
    """What became of the trials of one kind."""

    trials: int = 0
    held: int = 0
    seconds_to_rest: list[float] = field(default_factory=list)
    outcomes: Counter[str] = field(default_factory=Counter)
    failures: list[str] = field(default_factory=list)
    counted: Counter[str] = field(default_factory=Counter)

    def figures(self) -> Figures:
        """For the page."""
        found: Figures = {"trials": self.trials, "held": self.held}
        if self.seconds_to_rest:
            found["median_s_to_rest"] = round(statistics.median(self.seconds_to_rest), 2)
            found["longest_s_to_rest"] = round(max(self.seconds_to_rest), 2)
        found |= dict(self.counted)
        if self.outcomes:
            found["ended"] = dict(self.outcomes.most_common())
        if self.failures:
            found["failures"] = self.failures
        return found


def kills(effort: Effort, logs: Path) -> dict[str, Figures]:
    """one process is killed while the arm moves: arm at rest, cause told, run readable"""
    return _tested("tests/daemon/test_kills.py", effort.times(100), logs, effort.only)


def suspensions(effort: Effort, logs: Path) -> dict[str, Figures]:
    """one process stands still for a while (SIGSTOP) while the arm moves, then goes on"""
    return _tested("tests/daemon/test_suspended.py", effort.times(5), logs, effort.only)


def requests(effort: Effort, logs: Path) -> dict[str, Figures]:
    """requests that schemathesis draws from all operations, valid and invalid ones"""
    path = "tests/api/test_schema.py::test_many_requests"
    return _tested(path, effort.times(60), logs)


def damaged_files(effort: Effort, logs: Path) -> dict[str, Figures]:
    """damaged bags, runs, models, profiles, URDFs, CSV files: read, or refused in one line"""
    return _tested("tests/damage/test_damaged_files.py", effort.times(400), logs)


def sequences(effort: Effort, logs: Path) -> dict[str, Figures]:
    """sequences of commands and faults that a fuzzer draws: no torque that nobody watches, none
    where none may be; joints outside their envelope get some for 12 cycles at most"""
    path = "tests/control/test_state_machine.py::test_nor_do_many_others"
    return _tested(path, effort.times(10_000), logs)


PARTS: dict[str, Callable[[Effort, Path], dict[str, Figures]]] = {
    "kills": kills, "suspensions": suspensions, "requests": requests,
    "damaged_files": damaged_files, "sequences": sequences,
}  # fmt: skip


def _tested(path: str, trials: int, logs: Path, only: str = "") -> dict[str, Figures]:
    """One entry per test function."""
    logs.mkdir(parents=True, exist_ok=True)
    name = Path(path.partition("::")[0]).stem
    with tempfile.TemporaryDirectory() as place:
        report = Path(place) / "report.xml"
        command = [sys.executable, "-m", "pytest", path, "--long", "--trials", str(trials)]
        command += [
            "-p",
            "no:cacheprovider",
            f"--junitxml={report}",
            f"--timeout={LONGEST}",
            *(["-k", only] if only else []),
        ]
        with (logs / f"{name}-{os.getpid()}.log").open("w") as log:
            subprocess.run(command, cwd=ROOT, stdout=log, stderr=subprocess.STDOUT, check=False)
        return {kind: one.figures() for kind, one in tallied(report).items()}


def tallied(report: Path) -> dict[str, Tally]:
    """From pytest's report, by test function."""
    found: dict[str, Tally] = {}
    for case in xml.parse(report).iter("testcase"):
        if case.find("skipped") is not None:
            continue
        words = {p.get("name", ""): p.get("value", "") for p in case.iter("property")}
        kind = words.get("kind") or case.get("name", "").partition("[")[0].removeprefix("test_")
        one = found.setdefault(kind, Tally())
        one.trials += 1
        wrong = [w for tag in ("failure", "error") for w in case.findall(tag)]
        if wrong:
            said = " ".join(wrong[0].get("message", "").split())[:SHOWN]
            one.failures.append(f"{case.get('name')}: {said}")
            continue
        one.held += 1
        if "seconds to rest" in words:
            one.seconds_to_rest.append(float(ast.literal_eval(words["seconds to rest"])[1]))
        if "outcome" in words:
            one.outcomes[words["outcome"]] += 1
        for what in COUNTED:
            if what in words:
                one.counted[what] += int(words[what])
    return found
