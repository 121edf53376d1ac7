"""The demo: an arm hides an effect; record, identify, compare, diagnose, add; then the truth.

Everything is asked of the daemon over HTTP, as any client would. The story does not know what is
hidden, nor which question is the right one: it first asks what is missing in the model of the arm
as it was delivered. Where that leaves nothing, time passes, and it asks what has changed since.
The answer may be wrong, and then the story says so.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from pa10d.client import Client
from pa10d.common.errors import UserError
from pa10d.demo.bench import Bench
from pa10d.demo.hidden import Hidden
from pa10d.demo.truth import judged, verdict_on
from pa10d.demo.words import compared_words, fall_words, found_words, named, plan_words
from pa10d.services.doubts import new_plan
from pa10d.services.starting_set import FIT, JUDGE, STARTING_SET

Document = dict[str, Any]
Tell = Callable[[str], None]
Progress = Callable[[float, str], None]

LATER: tuple[Document, ...] = (
    {"kind": "excitation", "parameters": {"seed": 3}, "tags": [FIT]},
    {"kind": "point_to_point", "parameters": {"seed": 8}, "tags": [JUDGE]},
)
"""What is recorded when the arm is switched on again."""
MOST = 2  # experiments to settle a doubt


@dataclass
class Chapter:
    """One question, asked of one model on its own runs. held_out: runs that no fit has seen."""

    model: str
    fit: list[str]
    validate: list[str]
    frozen: bool = False
    found: Document = field(default_factory=dict)
    sheet: Document = field(default_factory=dict)
    tried: list[Document] = field(default_factory=list)
    models: list[str] = field(default_factory=list)
    before: list[float] = field(default_factory=list)
    after: list[float] = field(default_factory=list)
    held_out: tuple[str, ...] = ()


@dataclass(frozen=True)
class Told:
    """How the story ended: the last chapter decides. right: None where nobody knows the truth."""

    hidden: Hidden
    chapters: tuple[Chapter, ...]
    right: bool | None
    truth: str
    seed: int

    @property
    def last(self) -> Chapter:
        """The chapter that found something, or the last one asked."""
        return self.chapters[-1]

    def document(self) -> Document:
        """JSON of ``demo``, but for the report."""
        last = self.last
        findings = last.found["findings"]
        found_joints = findings[0]["joints"] if findings else []
        # what a foreign plant hides, and where, is not known here: then it is the answer's joint
        joints = list(self.hidden.joints) if self.hidden.effects else found_joints
        return {
            "hidden": self.hidden.name,
            "joint": joints[0] if joints else None,
            "found": findings[0]["effect"] if findings else None,
            "rms_before": last.before,
            "rms_after": last.after,
            "right": self.right,
            "hidden_joints": list(self.hidden.joints),
            "found_joints": found_joints,
            "parameters": [dict(entry) for entry in self.hidden.effects],
            "seed": self.seed,
            "verdict": last.found["verdict"],
            "frozen": last.frozen,
            "findings": findings,
            "unexplained": last.found["unexplained"],
            "noise_floor": last.found["noise_floor"],
            "experiments": [entry for chapter in self.chapters for entry in chapter.tried],
            "models": [name for chapter in self.chapters for name in chapter.models],
        }


class Story:
    """Told step by step; ``tell``: a line of it, ``progress``: how far the present step is."""

    def __init__(self, arm: Client, prefix: str, tell: Tell, progress: Progress) -> None:
        self._arm, self._prefix, self._tell, self._progress = arm, prefix, tell, progress
        self._made = 0

    def record(self, plans: Sequence[Document]) -> tuple[list[str], list[str]]:
        """Run experiments → runs to fit to, runs to judge by."""
        runs: dict[str, list[str]] = {FIT: [], JUDGE: []}
        for plan in plans:
            found = self._arm.experiment(plan=plan, progress=self._progress)
            if plan["kind"] == "first_motion":
                self._tell_joints(found)
                continue
            runs[plan["tags"][0]] += found["runs"]
            seconds = found["recorded"][0]["duration"]
            self._tell(f"   {plan['kind']}: {seconds:.0f} s, to {plan['tags'][0]}.")
        return runs[FIT], runs[JUDGE]

    def _tell_joints(self, found: Document) -> None:
        """What the first motion measured: all in the report, here the odd ones alone."""
        seconds = sum(run["duration"] for run in found["recorded"])
        self._tell(f"   first_motion: {seconds:.0f} s, measures each joint and sets the gains.")
        for line in found.get("notes", []):
            self._tell(f"   {line}")

    def ask(self, model: str, fit: list[str], validate: list[str], frozen: bool) -> Chapter:
        """Diagnose; where the answer is in doubt, run the experiment it asks for, and again."""
        chapter = Chapter(model, list(fit), list(validate), frozen, held_out=tuple(validate))
        while True:
            job = self._arm.start(
                "diagnoses",
                {"model": model, "fit": chapter.fit, "validate": chapter.validate,
                 "frozen": frozen},
            )  # fmt: skip
            chapter.found = self._arm.wait(job, self._progress)["result"]
            chapter.sheet = self._arm.sheet(job["id"])
            self._tell(f"   {found_words(chapter.found)}")
            if len(chapter.tried) == MOST or not self._settle(chapter):
                return chapter

    def _settle(self, chapter: Chapter) -> bool:
        """One experiment more, if one is asked for that was not tried and can be run."""
        finding = new_plan(chapter.found["findings"], [e["plan"] for e in chapter.tried])
        if finding is None:
            return False
        self._tell(f"   {plan_words(finding)}")
        plan = finding["next_experiment"]
        try:
            runs = self._arm.experiment(plan=plan, progress=self._progress)["runs"]
        except UserError as error:
            self._tell(f"   It could not be run: {error}")
            chapter.tried.append({"plan": plan, "runs": [], "error": str(error)})
            return False
        chapter.tried.append({"plan": plan, "runs": runs})
        chapter.fit += runs
        chapter.validate += runs  # a run on both sides is split by time
        return True

    def add(self, chapter: Chapter) -> None:
        """What was found becomes new versions; all are judged on the runs that no fit has seen."""
        model = chapter.model
        for finding in chapter.found["findings"]:
            self._made += 1
            name = f"{self._prefix}m{self._made}"
            try:
                self._arm.add(
                    model, finding["effect"], finding["joints"], chapter.fit, name,
                    self._progress, replace=True,
                )  # fmt: skip
            except UserError as error:
                self._tell(f"   {named(finding)} could not be added: {error}")
                break
            chapter.models.append(name)
            model = name
        if model == chapter.model and chapter.before:
            return  # compared already
        judged_by = self._arm.compare(model, chapter.held_out, self._progress)
        errors = {step["model"]: step["rms"] for step in judged_by["history"]}
        chapter.before, chapter.after = errors[chapter.model], errors[model]

    def first_chapter(self) -> Chapter:
        """The arm as it was delivered: what is missing in its textbook model?"""
        tell, model = self._tell, f"{self._prefix}m0"
        tell("2. It is moved by experiments, over HTTP and CAN; angles and torques are recorded.")
        fit, validate = self.record(STARTING_SET)
        tell("3. The textbook model is fitted: rigid bodies, rotors, Coulomb and viscous friction.")
        self._arm.identify(fit, model, self._progress, replace=True)
        tell("4. Is the model right? It is judged by the runs that the fit has not seen.")
        compared = self._arm.compare(model, validate, self._progress)
        tell(f"   {compared_words(compared)}")
        tell("5. Which effect is missing? Every one of the library is tried on every joint.")
        chapter = self.ask(model, fit, validate, frozen=False)
        chapter.models.append(model)
        chapter.before = chapter.after = compared["pooled"]["rms"]
        self._tell_gain(chapter, "6")
        return chapter

    def second_chapter(self, model: str) -> Chapter:
        """The same arm some time later, its model as it was: what has changed?"""
        self._tell("7. Time passes; the arm is switched on again, and moves again.")
        fit, validate = self.record(LATER)
        self._tell("8. Has it changed? The model stays as it was; only what differs is looked for.")
        chapter = self.ask(model, fit, validate, frozen=True)
        self._tell_gain(chapter, "9")
        return chapter

    def _tell_gain(self, chapter: Chapter, number: str) -> None:
        self.add(chapter)
        if not chapter.found["findings"]:
            self._tell(f"{number}. There is nothing to add.")
            return
        self._tell(
            f"{number}. It is added as a new version of the model; the old one stays. "
            f"{fall_words(chapter.before, chapter.after)}"
        )


def play(bench: Bench, hidden: Hidden, seed: int, tell: Tell, progress: Progress) -> Told:
    """From a hidden effect to the truth."""
    story = Story(bench.client, f"demo{seed}-", tell, progress)
    chapters = [story.first_chapter()]
    # nobody changes an arm that somebody else simulates, and a model that is known to lack
    # something is no reference
    if chapters[0].found["verdict"] == "none" and not hidden.foreign:
        bench.time_passes()
        chapters.append(story.second_chapter(chapters[0].model))
    found = chapters[-1].found
    right = judged(hidden, found["findings"], found["unexplained"])
    truth = verdict_on(hidden, found["findings"], found["unexplained"])
    tell(f"Now the simulator tells what was hidden: {hidden.in_words()}.")
    tell(truth)
    return Told(hidden, tuple(chapters), right, truth, seed)
