"""What the questions return: errors, findings, promises; each shows itself in a notebook."""

from __future__ import annotations

from collections.abc import Hashable
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from pa10d.common.jsonable import JsonObject
from pa10d.compare import Comparison as Compared
from pa10d.compare import document
from pa10d.diagnose.outcome.diagnosis import Diagnosis as FoundOut
from pa10d.diagnose.outcome.words import in_json
from pa10d.face.model import Model, Parameter
from pa10d.face.run import Run
from pa10d.face.told import confusion, next_experiment, remaining, unexplained
from pa10d.face.values import Array, ByContent, Fixed, Said, frozen, listed, settled

if TYPE_CHECKING:
    from pa10d.figures.held_out import HeldOut
    from pa10d.report.finding_section import Asked


class Answer(ByContent):
    """An answer and the document that says the same as JSON."""

    _document: JsonObject

    def document(self) -> JsonObject:
        """As ``--json`` prints it."""
        return deepcopy(self._document)

    @property
    def content(self) -> Hashable:
        return settled(self._document)


@dataclass(frozen=True, repr=False)
class Where(Said):
    """A region that carries much of a joint's (from 1) squared error."""

    joint: int
    variable: str
    range: tuple[float, float]
    share: float
    sentence: str

    def __str__(self) -> str:
        return self.sentence


class Comparison(Answer):
    """A model's error on runs: (n,) N·m each, all runs together.

    rms, noise_floor (nan where this data cannot say), r2, max; where: the regions that carry most
    of it; cutoff_hz and mask: the band and samples that count; figures: Plotly, by name
    """

    def __init__(self, inner: Compared) -> None:
        self.inner = inner
        self._document = document(inner)
        scores = inner.pooled.scores
        self.rms, self.noise_floor = frozen(scores.rms), frozen(inner.pooled.noise_floor)
        self.r2, self.max = frozen(scores.r2), frozen(scores.max)
        self.cutoff_hz: float = self._document["cutoff_hz"]
        self.mask: str = self._document["mask"]
        self.where = tuple(
            Where(p["joint"], p["variable"], tuple(p["range"]), p["share"], p["sentence"])
            for p in self._document["where"]
        )

    @cached_property
    def figures(self) -> JsonObject:
        """Plotly figures as JSON: ``overview`` and per joint ``joints``."""
        from pa10d.figures import comparison_figures

        return comparison_figures(self.inner)

    def _page(self) -> str:
        from pa10d.report import compare_page

        return compare_page(self.inner)

    def __repr__(self) -> str:
        first = f"\n  {self.where[0]}" if self.where else ""
        return (
            f"<Comparison of {self.inner.model.name}: RMS {listed(self.rms)} N·m, "
            f"noise {listed(self.noise_floor)} N·m, below {self.cutoff_hz:.3g} Hz{first}>"
        )


class Finding(ByContent):
    """A missing effect. joints from 1; rms_before, rms_after: (n,) N·m on held-out data."""

    def __init__(self, document: JsonObject, of: Diagnosis, number: int) -> None:
        self._document, self._of, self._number = document, of, number
        self.effect: str = document["effect"]
        self.joints = tuple(document["joints"])
        self.parameters = Fixed(
            {
                name: Parameter(name, v["value"], v["std_error"], v["unit"], v["determined"])
                for name, v in document["parameters"].items()
            }
        )
        self.rms_before: Array = frozen(document["rms_before"])
        self.rms_after: Array = frozen(document["rms_after"])
        self.p_value: float = document["p_value"]
        self.confounded_with = tuple(map(confusion, document["confounded_with"]))
        self.next_experiment = next_experiment(document["next_experiment"])
        self.sentence: str = document["sentence"]

    @property
    def content(self) -> Hashable:
        return settled(self._document)

    def _page(self) -> str:
        from pa10d.report.notebook import finding_page

        return finding_page(self._of.inner, self._number, *self._of.shown)

    def __repr__(self) -> str:
        return f"<Finding: {self.sentence}>"


class Diagnosis(Answer):
    """verdict: "missing", "none" or "unknown"; findings best first; unexplained: structure that no
    effect explains; remaining: what is left, a line per joint."""

    def __init__(self, inner: FoundOut, fit: tuple[Run, ...], validate: tuple[Run, ...]) -> None:
        self.inner, self._fit, self._validate = inner, fit, validate
        self._document = in_json(inner)
        self.verdict: str = inner.verdict
        self.rms, self.noise_floor = frozen(inner.rms), frozen(inner.noise_floor)
        self.cutoff_hz = float(inner.cutoff)
        entries = enumerate(self._document["findings"])
        self.findings = tuple(Finding(entry, self, k) for k, entry in entries)
        self.unexplained = tuple(map(unexplained, self._document["unexplained"]))
        self.remaining = tuple(map(remaining, self._document["remaining"]))

    @property
    def model(self) -> Model:
        """The given model with all findings fitted in."""
        return Model(self.inner.kept)

    @cached_property
    def shown(self) -> tuple[HeldOut, Asked]:
        """The held-out side as every version sees it, and what was asked, for pages."""
        from pa10d.figures.held_out import held_out
        from pa10d.report.finding_section import Asked

        fit, validate = (tuple(r.name for r in runs) for runs in (self._fit, self._validate))
        asked = Asked(self.inner.versions[0].name, fit, validate, "ROBOT")
        return held_out(self.inner), asked

    def _page(self) -> str:
        from pa10d.report.diagnosis_page import diagnosis_page

        return diagnosis_page(self.inner, *self.shown)

    def __repr__(self) -> str:
        lines = [f.sentence for f in self.findings] or [f"verdict: {self.verdict}"]
        lines += [entry.sentence for entry in self.remaining]
        return "<Diagnosis\n  " + "\n  ".join(lines) + ">"


class Improvement(ByContent):
    """model: the last version; versions: all, the given one first; promised and achieved: (n,) N·m,
    what the diagnosis held out and what the stored model leaves on the same runs in the same band;
    diagnosis: what was found on the way."""

    def __init__(
        self, versions: tuple[Model, ...], promised: Array, achieved: Array, diagnosis: Diagnosis
    ) -> None:
        self.versions, self.diagnosis = versions, diagnosis
        self.promised, self.achieved = frozen(promised), frozen(achieved)

    @property
    def model(self) -> Model:
        return self.versions[-1]

    @property
    def content(self) -> Hashable:
        return self.versions, self.diagnosis

    def _page(self) -> str:
        from pa10d.report.notebook import improvement_page

        names = [version.name for version in self.versions]
        inner = self.diagnosis.inner
        return improvement_page(inner, names, self.promised, *self.diagnosis.shown)

    def __repr__(self) -> str:
        return (
            f"<Improvement in {len(self.versions) - 1} steps: promised {listed(self.promised)}, "
            f"achieved {listed(self.achieved)} N·m>"
        )
