"""What would settle a doubt, as files: a plan for this program, a motion for any other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from pa10d.common.errors import UserError
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.dynamics import Robot
from pa10d.investigation.motions import keep_previews, planned, preview
from pa10d.investigation.results import NamedEffect, Way
from pa10d.investigation.words import doubt_words
from pa10d.services.robots import load_robot
from pa10d.services.starting_set import SuggestedMotion
from pa10d.store.entries import own_folder
from pa10d.store.folders import write_text

RATE = 100.0  # Hz of the motion's file
FOLDER = "doubts"


def write_doubts(profile: str, findings: Sequence[NamedEffect], place: Path) -> list[Way | None]:
    """How each finding's doubt would be settled, None where it has none; the files are written into
    the folder ``doubts``, where of a search before nothing stays."""
    robot = load_robot(profile)[1]
    folder, shown = place / FOLDER, []
    ways: list[Way | None] = []
    for old in own_folder(folder).glob("*.*"):
        old.unlink()
    for number, finding in enumerate(findings, 1):
        plan = finding.next_experiment
        if plan is None:
            ways.append(None)
            continue
        seen = preview(robot, SuggestedMotion(plan.kind, plan.parameters), "settle")
        shown.append(seen)
        stem = f"{number}-{plan.kind}"
        way = Way(
            seconds=seen.motion.seconds,
            says=doubt_words(finding, plan),
            problem="; ".join(seen.problems),
            plan=f"{stem}.yaml",
            motion=f"{stem}.csv",
        )
        write_text(folder / f"{stem}.yaml", plan_text(plan, way.says))
        try:
            write_text(folder / f"{stem}.csv", motion_text(robot, plan))
        except UserError as error:
            way = replace(way, problem=str(error), motion=None)
        ways.append(way)
    keep_previews(place, shown)
    return ways


def plan_text(plan: NextExperiment, says: str) -> str:
    """What ``pa10d experiment --plan`` and the daemon's API take."""
    request = {"kind": plan.kind, "parameters": plan.parameters}
    head = f"# {says}\n# To run it: pa10d experiment --plan THIS-FILE\n"
    return head + yaml.safe_dump(request, sort_keys=False, allow_unicode=True)


def motion_text(robot: Robot, plan: NextExperiment) -> str:
    """CSV of time, s, and q1 … qn, rad: from rest to rest, at 100 Hz."""
    samples = planned(robot, plan.kind, plan.parameters)[0].sample(RATE)
    head = ",".join(["time", *(f"q{j + 1}" for j in range(robot.n))])
    rows = np.column_stack([samples.t, samples.q])
    lines = (",".join(f"{v:.9g}" for v in row) for row in rows)
    return "\n".join([head, *lines]) + "\n"
