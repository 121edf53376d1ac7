"""What is asked of the arm: one motion, or one motion under each control law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pa10d.common.jsonable import JsonObject
from pa10d.control.laws import WITH_MODEL, Law

FIRST = "first_motion"


@dataclass(frozen=True)
class MotionRequest:
    """One experiment. parameters: as the kind's own schema says (JSON: who builds the plan parses
    it); controller: None for the one in use; model: the id of the one that its law takes.

    replace: the run of this name, if there is one; recover: an arm that stands outside its position
    limits is brought back inside first."""

    kind: str
    parameters: JsonObject = field(default_factory=dict)
    name: str | None = None
    tags: Sequence[str] = ()
    controller: Law | None = None
    model: str | None = None
    replace: bool = False
    recover: bool = False

    @classmethod
    def of_plan(cls, plan: Mapping[str, Any], tags: Sequence[str] = ()) -> MotionRequest:
        """A plan, such as a diagnosis gives, as a whole request."""
        return cls(plan["kind"], plan.get("parameters") or {}, tags=tags)

    @property
    def is_first(self) -> bool:
        """Whether the arm's joints are measured: the servo's own affair."""
        return self.kind == FIRST

    def document(self) -> JsonObject:
        """As clients see what a job was asked for."""
        return {**vars(self), "tags": list(self.tags)}


@dataclass(frozen=True)
class LawUsed:
    """A control law, and the model that it takes."""

    controller: Law
    model: str | None = None


def laws_for(models: Sequence[str]) -> list[LawUsed]:
    """Every law to compare: PID alone, then each law with each model."""
    return [LawUsed("pid"), *(LawUsed(law, model) for law in WITH_MODEL for model in models)]


@dataclass(frozen=True)
class TrackingRequest:
    """One motion under each law; models: ids, from the least to the best; name: of the runs, which
    get a number each."""

    kind: str
    parameters: JsonObject
    models: Sequence[str]
    name: str | None = None
    replace: bool = False

    @property
    def laws(self) -> list[LawUsed]:
        """In the order in which they are tried."""
        return laws_for(self.models)

    def motions(self, tags: Sequence[str]) -> list[MotionRequest]:
        """One for each law."""
        return [
            MotionRequest(
                self.kind, self.parameters, self.run_name(k), tags, law.controller, law.model,
                self.replace,
            )
            for k, law in enumerate(self.laws)
        ]  # fmt: skip

    def run_name(self, k: int) -> str | None:
        """Of the k-th law's run, from 0; None: numbered after the kind."""
        return None if self.name is None else f"{self.name}-{k + 1}"

    def document(self) -> JsonObject:
        """As clients see what a job was asked for."""
        return {**vars(self), "models": list(self.models)}
