"""An investigation as JSON: what ``pa10d investigate --json`` and the API say."""

from __future__ import annotations

from pathlib import Path

from pa10d.common.jsonable import JsonObject, plain
from pa10d.investigation.archive import REPORT
from pa10d.investigation.doubts import FOLDER
from pa10d.investigation.results import NamedEffect, Way
from pa10d.investigation.state import Investigation, Step
from pa10d.store.entries import is_own_file
from pa10d.store.location import data_folder

DIAGNOSED = (
    "rms",
    "noise_floor",
    "cutoff_hz",
    "mask",
    "unexplained",
    "remaining",
    "judged_on",
    "frozen",
    "warnings",
)  # fmt: skip


def document(state: Investigation, data: str) -> JsonObject:
    """Steps with status and ids, and, as far as it is, verdict, findings, errors, report."""
    place = data_folder(data) / "investigations" / state.id
    searches, added, judged = state.done("diagnose"), state.done("add"), state.done("judge")
    found = searches[-1].result if searches else {}
    promise = added[-1].result if added else {}
    last = state.versions[-1] if state.versions else None
    report = place / REPORT
    return {
        "id": state.id,
        "name": state.name,
        "robot": state.robot,
        "status": state.status,
        "error": state.error or None,
        "question": state.question,
        "moves": state.moves,
        "budget_minutes": state.minutes,
        "moved_seconds": state.moved,
        "created": state.created,
        "steps": [_step(step) for step in state.steps],
        "verdict": found.get("verdict"),
        "findings": found.get("findings", []),
        **{key: found.get(key) for key in DIAGNOSED},
        "model": last,
        "models": state.versions,
        "runs": {
            "fit": state.to_fit,
            "validate": state.to_judge,
            "fresh": state.recorded("fresh"),
        },
        "before": promise.get("before"),
        "promised": promise.get("promised"),
        "achieved": promise.get("achieved"),
        "judged": judged[-1].result if judged else None,
        "doubts": [_doubt(one, one.settling, place) for one in state.findings if one.settling],
        "left_out": [s.said for s in state.steps if s.status == "left_out" and s.kind == "motion"],
        "report": str(report) if state.done("report") and is_own_file(report) else None,
    }


def brief(state: Investigation) -> JsonObject:
    """For a list."""
    keys = ("id", "name", "robot", "status", "question", "moves", "created")
    return {key: getattr(state, key) for key in keys}


def _step(step: Step) -> JsonObject:
    shown = step.model_dump(exclude={"result"})
    motion = shown.pop("motion")
    return {
        **shown,
        "seconds": None if motion is None else motion["seconds"],
        "experiment": None if motion is None
        else {"kind": motion["kind"], "parameters": motion["parameters"]},
        "purpose": None if motion is None else motion["purpose"],
        "why": "" if motion is None else motion["why"],
    }  # fmt: skip


def _doubt(finding: NamedEffect, way: Way, place: Path) -> JsonObject:
    return {
        "effect": finding.effect, "joints": finding.joints,
        "confounded_with": plain(finding.confounded_with), "seconds": way.seconds,
        "says": way.says, "problem": way.problem or None,
        "plan": str(place / FOLDER / way.plan),
        "motion": None if way.motion is None else str(place / FOLDER / way.motion),
    }  # fmt: skip
