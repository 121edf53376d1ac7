"""What a diagnosis says, as objects and as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject, plain
from pa10d.common.words import joint_words, listed, percent
from pa10d.diagnose.evidence.tails import tails
from pa10d.diagnose.outcome.held import HeldAtNone, held_words
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.diagnose.search.delivery import delivered, warnings
from pa10d.diagnose.unknown.between_runs import Apart
from pa10d.diagnose.unknown.claims import Unexplained
from pa10d.diagnose.unknown.geometry import OtherGeometry
from pa10d.diagnose.unknown.remaining import Remaining
from pa10d.diagnose.unknown.structure import Structure
from pa10d.effects import Value
from pa10d.judgement import Judgement
from pa10d.model import Term, TorqueModel
from pa10d.model.estimates import no_estimates
from pa10d.regression.equation import RunEquation

Array = NDArray[np.float64]
Verdict = Literal["missing", "none", "unknown"]


@dataclass(frozen=True)
class Confusion:
    """Another explanation that this data cannot tell from the finding."""

    effect: str
    joints: tuple[int, ...]
    why: str


@dataclass(frozen=True)
class Finding:
    """One missing effect (or change), on top of the findings before it.

    rms_before, rms_after: (n,) N·m held out, refitted without and with it; before the first change
    of a frozen model, as that was given
    size: N·m RMS of its torque on the held-out side where it acts, and its standard error
    slope: of the held-out residual on the predicted change; 1 for a true effect
    certain: of a frozen model, that it takes more of a joint than may come without a change
    was_there: of a frozen model, whether its own runs had it already; None: they do not tell, or
    nobody asked them
    """

    term: Term
    parameters: dict[str, Value]
    rms_before: Array
    rms_after: Array
    p_value: float
    slope: float
    size: Value
    confounded_with: tuple[Confusion, ...]
    next_experiment: NextExperiment | None
    sentence: str
    was_there: bool | None = None
    certain: bool = False

    def document(self) -> JsonObject:
        """As INTERFACES has it, and a little more."""
        return {
            "effect": self.term.effect_id,
            "joints": [j + 1 for j in self.term.joints],
            "parameters": {name: v.document() for name, v in self.parameters.items()},
            "rms_before": self.rms_before.tolist(),
            "rms_after": self.rms_after.tolist(),
            "p_value": self.p_value,
            "slope": self.slope,
            "size": {
                "value": self.size.value,
                "std_error": self.size.std_error,
                "unit": self.size.unit,
            },
            "confounded_with": [
                {"effect": c.effect, "joints": [j + 1 for j in c.joints], "why": c.why}
                for c in self.confounded_with
            ],
            "next_experiment": self.next_experiment and self.next_experiment.document(),
            "sentence": self.sentence,
            "was_there": self.was_there,
        }


@dataclass(frozen=True)
class Diagnosis:
    """The whole answer.

    rms: (n,) N·m of the given model, refitted unless frozen, on the held-out side; where beside is
    said, of that model with what it lacked
    as_given, left: the given model as it came, and the one with all findings, there
    remaining: what is left on each joint, and what this data can say about it
    model: with all findings fitted in; versions: one model per step, the given one (refitted
    unless frozen) first, as they were judged; stored: those after it as they are kept. They are the
    same, unless runs were cut into a fitted and a held-out half: then they are fitted to both
    fitted, held_out: the runs of both sides as they were looked at: behind the equation's low-pass,
    with the samples that count. Whoever draws or tells more of it later reads no run again
    judged_on: in words, which data the fit has not seen
    identified_from: names of the given model's own runs
    absorbed: these data cannot tell it from what the model has already
    only: the one suspicion that was looked for, as people call it; empty: the whole library was
    lacked: joints (0-based) that keep no more than a model that stays as it was may leave though
    nothing changed
    beside: what the given model lacks of its own data, where the change was sought beside that
    with_reversals: (n,) N·m, ``rms`` where reversals count, too
    stood: of a frozen model that was moved far, within its own doubt: what it left as it was given
    knocked: joints (0-based) whose error lies in a few moments of the runs
    above_band: joints (0-based) and, in words, what the low-pass takes away that is more than all
    that it leaves
    told: of what somebody knew when the given model was identified, which a search does not know
    passed: what the torque channel has passed, where this search has seen it otherwise than
        identification; thought: what that took it for
    sharper: of a frozen model: joints (0-based) whose dry friction turns round more sharply than it
    knows, and from what speed to which that moved, rad/s (m/s)
    read_wrong: of its runs, what speaks for columns that were read wrongly
    """

    verdict: Verdict
    rms: Array
    as_given: Judgement
    left: Judgement
    cutoff: float
    findings: tuple[Finding, ...]
    unexplained: tuple[Unexplained, ...]
    remaining: tuple[Remaining, ...]
    model: TorqueModel
    versions: tuple[TorqueModel, ...]
    stored: tuple[TorqueModel, ...]
    fitted: tuple[RunEquation, ...]
    held_out: tuple[RunEquation, ...]
    judged_on: str
    frozen: bool
    identified_from: tuple[str, ...] = ()
    with_reversals: Array | None = None
    only: str = ""
    absorbed: bool = False
    lacked: tuple[int, ...] = ()
    beside: str = ""
    stood: str = ""
    knocked: tuple[int, ...] = ()
    above_band: Mapping[int, str] = field(default_factory=dict)
    told: tuple[str, ...] = ()
    passed: str = ""
    thought: str = ""
    sharper: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    read_wrong: tuple[str, ...] = ()
    at_none: tuple[HeldAtNone, ...] = ()  # terms that are held at none

    @property
    def heading(self) -> str:
        """What stands above the findings."""
        if not self.frozen:
            return "Missing"
        all_there = all(finding.was_there for finding in self.findings)
        return "Missing, not changed" if all_there else "Changed"

    @property
    def begins(self) -> str:
        """What the first of the versions is, to whose errors ``rms`` belongs."""
        if self.beside:
            return "with what it lacked"
        return "as given" if self.frozen else "refitted"

    @property
    def stages(self) -> tuple[tuple[str, Array], ...]:
        """What stands side by side wherever errors are told, each with (n,) N·m held out: the model
        as it was given, what it became before anything was found, and each finding more. So the
        first is what the model leaves wherever else it is judged on these runs."""
        anew = () if self.begins == "as given" else ((self.begins, self.rms),)
        added = ((f"+ {found.term.label}", found.rms_after) for found in self.findings)
        return ("as given", self.as_given.rms), *anew, *added

    @property
    def noise_floor(self) -> Array:
        """(n,) N·m; nan where this data does not show it."""
        return self.left.floor.values

    @property
    def kept(self) -> TorqueModel:
        """The last version as it is kept."""
        return self.stored[-1] if self.stored else self.model

    @property
    def mapped(self) -> tuple[Structure, ...]:
        """What is unexplained and of which one or two quantities are known that it depends on."""
        return tuple(one for one in self.unexplained if isinstance(one, Structure))

    @property
    def contradicted(self) -> tuple[Apart, ...]:
        """Joints of which fitted runs ask for different parameters."""
        return tuple(one for one in self.unexplained if isinstance(one, Apart))

    @property
    def misplaced(self) -> tuple[OtherGeometry, ...]:
        """Joints whose errors ask for another geometry than the URDF's."""
        return tuple(one for one in self.unexplained if isinstance(one, OtherGeometry))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is to be known before the model is used."""
        found = [finding.term for finding in self.findings]
        beside = [said for said in (self.beside, self.stood if found else "") if said]
        own = (
            *self.read_wrong,
            *self._apart(),
            *self._misplaced(),
            *held_words(self.at_none),
            *self._no_estimates(),
            *self._own_runs(),
            *self._smoothed(),
            *self._sharper(),
            *self._forgotten(),
            *self._lighter(),
            *beside,
        )
        if not found:
            return own
        worse = warnings(self.kept, bool(self.beside))
        return (*own, *tails(self.model, found, self.fitted).values(), *worse)

    def _apart(self) -> tuple[str, ...]:
        """What to do where fitted runs contradict each other."""
        if not self.contradicted:
            return ()
        one = self.contradicted[0]
        joints = joint_words([a.joint for a in self.contradicted])
        if one.all_along:
            return (
                f"of {joints} the fitted runs alone do not tell {listed(one.effects)} from what "
                "the model has in its place: fit to motion like the held-out one, too",
            )
        if one.held_out:
            return (
                f"{listed(one.runs)} {'asks' if len(one.runs) == 1 else 'ask'} for other "
                f"parameters of {joints} than the fitted runs; "
                f"look what was changed between {listed(one.others)} and {listed(one.runs)}, and "
                "ask of them what has changed (frozen)",
            )
        if one.at is not None:
            return (
                f"no one model of {joints} is right before and after {one.at:.1f} s of "
                f"{listed(one.runs)}; look what happened then (a load, a brake, a cable), and "
                "identify with one side of that left out (--leave-out); what came or went a run "
                "tells that has it from its beginning (frozen)",
            )
        return (
            f"the fitted runs ask for different parameters of {joints}, so one model of all of "
            f"them is right in none; look what was changed between {listed(one.others)} and "
            f"{listed(one.runs)}, fit to one side alone, and ask of the other what has changed "
            "(frozen)",
        )

    def _misplaced(self) -> tuple[str, ...]:
        """What to do where the URDF's geometry may be wrong."""
        if not self.misplaced:
            return ()
        return (
            f"the arm may not be as its URDF says: {self.misplaced[0].words}; compare both, and "
            "identify anew once they agree: bodies and effects bend to what is wrong",
        )

    def _forgotten(self) -> tuple[str, ...]:
        """What the versions do without."""
        if not (self.told and self.findings) or self.frozen:
            return ()
        return (
            f"the given model was identified beside what was known of {listed(self.told)}; these "
            "versions are fitted to the data alone",
        )

    def _sharper(self) -> tuple[str, ...]:
        """What a frozen model never knew of its dry friction."""
        robot = self.model.robot
        return tuple(
            f"dry friction of joint {j + 1} turns round more sharply (within {now:.2g} "
            f"{robot.angle_unit(j)}/s) than the model has it ({was:.2g}): hardly a change, rather "
            "what faster motion did not show when it was identified. What is told here is beside "
            "the sharper one"
            for j, (was, now) in self.sharper.items()
        )

    def _smoothed(self) -> tuple[str, ...]:
        """What the given model did not know of its torque channel."""
        if not self.passed and not self.thought:
            return ()
        if not self.passed:
            return (
                f"identification took the recorded torque to have passed {self.thought}; beside "
                "what is told here it shows no low-pass, it is only late: the model fitted anew "
                "goes without",
            )
        saw = f"took it for {self.thought}" if self.thought else "saw none"
        beside = ", which shows as it is beside all that is told here" if self.findings else ""
        return (
            f"the torque channel smooths{beside}: the recorded torque has passed {self.passed}, or "
            f"something like it (identification {saw}); the model fitted anew accounts for it",
        )

    def _lighter(self) -> tuple[str, ...]:
        """What friction of a load hides of the weight that no other joint feels."""
        carries = self.model.robot.carries()
        shared = (carries.astype(int) @ carries.T.astype(int)).sum(axis=1) - carries.sum(axis=1)
        said = []
        for term in (finding.term for finding in self.findings):
            if not term.effect.reads_as_load or shared[term.joints[0]] or self.frozen:
                continue
            most = percent(min(float(term.coefficients[0]), 1.0))
            said.append(
                f"what joint {term.joints[0] + 1} carries may be up to {most} lighter: friction "
                "that is larger while the motor drives reads as load. Weigh it, or measure torque "
                "behind the gear"
            )
        return tuple(said)

    def _no_estimates(self) -> tuple[str, ...]:
        """Terms that the model has besides what was found, whose values nothing can have."""
        found = {(f.term.effect_id, f.term.joints) for f in self.findings}
        said = [
            no_estimates(term, self.model.term_values(k))
            for k, term in enumerate(self.model.terms)
            if (term.effect_id, term.joints) not in found
        ]
        return tuple(text for text in said if text)

    def _own_runs(self) -> tuple[str, ...]:
        """That a change is sought in runs from before it, where it is."""
        own = set(self.identified_from) & {run.name for run in self.fitted}
        if not self.frozen or not own:
            return ()
        return (
            f"the model was identified from {listed(sorted(own))}, so nothing has changed there, "
            "and a change that only other runs have cannot be named; fit runs from after the "
            "change, and judge by others from after it",
        )

    def document(self) -> JsonObject:
        """JSON of ``diagnose``, without its first sentence (``words.in_json``)."""
        return {
            "verdict": self.verdict,
            "rms": self.rms.tolist(),
            "rms_as_given": plain(self.as_given.rms),
            "rms_with_reversals": plain(self.with_reversals),
            **self.left.floor.document(),
            "cutoff_hz": self.cutoff,
            "mask": self.left.mask,
            "refitted": not self.frozen or bool(self.beside),
            "runs": list(self.left.runs),
            "findings": [f.document() for f in self.findings],
            "unexplained": [
                {
                    "joint": s.joint + 1,
                    "depends_on": list(s.variables),
                    "share": s.share,
                    "rms": s.rms,
                    "p_value": s.p_value,
                }
                for s in self.unexplained
            ],
            "promised": plain(delivered(self.kept).promised),
            "achieved": plain(delivered(self.kept).achieved),
            "remaining": [line.document() for line in self.remaining],
            "judged_on": self.judged_on,
            "frozen": self.frozen,
            "warnings": list(self.warnings),
        }
