"""The demo: an arm hides an effect; it is investigated; then the simulator tells the truth.

Everything is asked of the daemon over HTTP, as any client would. The story does not know what is
hidden, nor which question is the right one: it first asks what is missing in the model of the arm
as it was delivered. Where that leaves nothing, time passes, and it asks what has changed since.
The answer may be wrong, and then the story says so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pa10d.client import Client
from pa10d.common.jsonable import JsonObject, parsed
from pa10d.demo.bench import Bench
from pa10d.demo.hidden import Hidden
from pa10d.demo.truth import judged, verdict_on
from pa10d.investigation.results import Searched

Tell = Callable[[str], None]
Progress = Callable[[float, str], None]

OVER = ("done", "left_out")


@dataclass(frozen=True)
class Told:
    """How the story ended. chapters: investigations as JSON, one per question; the last decides.
    right: None where nobody knows the truth."""

    hidden: Hidden
    chapters: tuple[JsonObject, ...]
    right: bool | None
    truth: str
    seed: int

    @property
    def last(self) -> JsonObject:
        """The chapter that found something, or the last one asked."""
        return self.chapters[-1]

    def document(self) -> JsonObject:
        """JSON of ``demo``, but for the report."""
        last = self.last
        findings = last["findings"]
        found_joints = findings[0]["joints"] if findings else []
        # what a foreign plant hides, and where, is not known here: then it is the answer's joint
        joints = list(self.hidden.joints) if self.hidden.effects else found_joints
        return {
            "hidden": self.hidden.name,
            "joint": joints[0] if joints else None,
            "found": findings[0]["effect"] if findings else None,
            "rms_before": last["judged"]["before"],
            "rms_after": last["judged"]["after"],
            "right": self.right,
            "hidden_joints": list(self.hidden.joints),
            "found_joints": found_joints,
            "parameters": [dict(entry) for entry in self.hidden.effects],
            "seed": self.seed,
            "verdict": last["verdict"],
            "frozen": last["question"] == "changed",
            "findings": findings,
            "unexplained": last["unexplained"],
            "noise_floor": last["noise_floor"],
            "experiments": [step for chapter in self.chapters for step in settling(chapter)],
            "models": list(dict.fromkeys(m for c in self.chapters for m in c["models"])),
        }


def settling(chapter: JsonObject) -> list[JsonObject]:
    """The experiments that were run, or could not be, to settle a doubt."""
    return [step for step in chapter["steps"] if step["purpose"] == "settle"]


def answered(chapter: JsonObject) -> str:
    """What its last search said."""
    searches = [step for step in chapter["steps"] if step["kind"] == "diagnose"]
    return str(searches[-1]["said"])


def play(bench: Bench, hidden: Hidden, seed: int, tell: Tell, progress: Progress) -> Told:
    """From a hidden effect to the truth."""
    tell("2. What is missing in its model? It is moved, over HTTP and CAN, and investigated.")
    chapters = [chapter(bench.client, tell, progress)]
    # nobody changes an arm that somebody else simulates, and a model that is known to lack
    # something is no reference
    if chapters[0]["verdict"] == "none" and not hidden.foreign:
        tell("3. Time passes; the arm is switched on again. Has it changed?")
        bench.time_passes()
        chapters.append(chapter(bench.client, tell, progress, since=chapters[0]["model"]))
    found = parsed(Searched, chapters[-1])
    right = judged(hidden, found.findings, found.unexplained)
    truth = verdict_on(hidden, found.findings, found.unexplained)
    tell(f"Now the simulator tells what was hidden: {hidden.in_words()}.")
    tell(truth)
    return Told(hidden, tuple(chapters), right, truth, seed)


def chapter(arm: Client, tell: Tell, progress: Progress, **asked: Any) -> JsonObject:
    """One question, asked and answered step by step → the investigation's document."""
    planned = arm.prepare_investigation(progress, **asked)
    known = {step["id"]: "waiting" for step in planned["steps"]}

    def news(state: JsonObject) -> None:
        for step in state["steps"]:
            if known.get(step["id"]) != step["status"]:
                known[step["id"]] = step["status"]
                if step["status"] in OVER and step["kind"] != "report":
                    tell(f"   {step['title']}. {step['said']}")

    done = arm.investigate(planned["id"], progress, news, recover=True)
    news(done)
    return done
