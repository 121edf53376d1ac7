"""What is known of an experiment so far; whoever carries it out fills it in as it goes."""

from __future__ import annotations

from dataclasses import dataclass, field

from pa10d.common.jsonable import JsonObject, plain
from pa10d.experiments.checks import Check


@dataclass(frozen=True)
class RecordedRun:
    """A run that was recorded. duration: s."""

    id: str
    name: str
    status: str
    duration: float


@dataclass
class Outcome:
    """kind: of the experiment; runs: ids; seconds: of motion; notes: what differs from what was
    asked for; tuned: what was set of the servo, of which nobody has to do anything. None: not
    known yet, or not of this kind.

    plan, adjusted, analysis and joints are JSON that another process computed, for clients."""

    kind: str
    runs: list[str] = field(default_factory=list)
    recorded: list[RecordedRun] = field(default_factory=list)
    plan: JsonObject | None = None
    checks: list[Check] | None = None
    seconds: float | None = None
    adjusted: JsonObject | None = None
    notes: list[str] = field(default_factory=list)
    tuned: list[str] = field(default_factory=list)
    analysis: JsonObject | None = None
    recommendation: list[str] | None = None
    joints: JsonObject | None = None

    def document(self) -> JsonObject:
        """For clients: what is known."""
        told = {key: plain(value) for key, value in vars(self).items() if value is not None}
        for unsaid in ("notes", "tuned"):
            if not told[unsaid]:
                del told[unsaid]
        if self.plan is not None and self.seconds is not None:
            told.setdefault("adjusted", None)  # it moved as it was asked to
        return told


@dataclass
class SeriesOutcome:
    """One experiment after the other, and all their runs."""

    runs: list[str] = field(default_factory=list)
    experiments: list[Outcome] = field(default_factory=list)

    def document(self) -> JsonObject:
        """For clients."""
        return {"runs": self.runs, "experiments": [one.document() for one in self.experiments]}
