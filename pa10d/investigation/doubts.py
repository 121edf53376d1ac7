"""What would settle a doubt, as files: a plan for this program, a motion for any other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pa10d.common.errors import UserError
from pa10d.dynamics import Robot
from pa10d.investigation.motions import keep_previews, planned, preview
from pa10d.investigation.words import doubt_words
from pa10d.services.robots import load_robot
from pa10d.store.folders import write_text

RATE = 100.0  # Hz of the motion's file
FOLDER = "doubts"


def write_doubts(profile: str, findings: Sequence[dict[str, Any]], place: Path) -> None:
    """Every finding with a ``next_experiment`` gets ``settling``: seconds, says, and its files'
    names in the folder ``doubts``; of a search before nothing stays there."""
    robot = load_robot(profile)[1]
    folder, shown = place / FOLDER, []
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.*"):
        old.unlink()
    for number, finding in enumerate(findings, 1):
        plan = finding["next_experiment"]
        if plan is None:
            continue
        seen = preview(robot, plan, "settle")
        shown.append(seen)
        stem = f"{number}-{plan['kind']}"
        finding["settling"] = {
            "seconds": seen.motion.seconds,
            "says": doubt_words(finding),
            "problem": "; ".join(seen.problems),
            "plan": f"{stem}.yaml",
            "motion": f"{stem}.csv",
        }
        write_text(folder / f"{stem}.yaml", plan_text(finding))
        try:
            write_text(folder / f"{stem}.csv", motion_text(robot, plan))
        except UserError as error:
            finding["settling"] |= {"problem": str(error), "motion": None}
    keep_previews(place, shown)


def plan_text(finding: Mapping[str, Any]) -> str:
    """What ``pa10d experiment --plan`` and the daemon's API take."""
    plan = finding["next_experiment"]
    body = {"kind": plan["kind"], "parameters": dict(plan.get("parameters") or {})}
    head = f"# {finding['settling']['says']}\n# To run it: pa10d experiment --plan THIS-FILE\n"
    return head + yaml.safe_dump(body, sort_keys=False, allow_unicode=True)


def motion_text(robot: Robot, plan: Mapping[str, Any]) -> str:
    """CSV of time, s, and q1 … qn, rad: from rest to rest, at 100 Hz."""
    samples = planned(robot, plan)[0].sample(RATE)
    head = ",".join(["time", *(f"q{j + 1}" for j in range(robot.n))])
    rows = np.column_stack([samples.t, samples.q])
    lines = (",".join(f"{v:.9g}" for v in row) for row in rows)
    return "\n".join([head, *lines]) + "\n"
