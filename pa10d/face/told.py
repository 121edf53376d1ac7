"""What a diagnosis says, part by part: values that never change."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from pa10d.common.jsonable import JsonObject, parsed
from pa10d.diagnose.outcome import settling
from pa10d.face.values import Fixed, Said, settled


class ByKey(Said):
    """``told["joint"]`` is ``told.joint``: the names are those of the JSON document."""

    def __getitem__(self, key: str) -> Any:
        if key.startswith("_") or not hasattr(self, key):
            raise KeyError(key)
        return getattr(self, key)


@dataclass(frozen=True, repr=False)
class Confusion(ByKey):
    """Another explanation that this data cannot tell from the finding. joints: from 1."""

    effect: str
    joints: tuple[int, ...]
    why: str

    def __str__(self) -> str:
        where = f" J{','.join(map(str, self.joints))}" if self.joints else ""
        return f"{self.effect}{where}: {self.why}"


@dataclass(frozen=True, eq=False, repr=False)
class NextExperiment(ByKey):
    """What to run to settle a doubt. parameters: as the kind's own schema says; apart: standard
    errors by which the two explanations should then differ, or None."""

    kind: str
    parameters: Mapping[str, Any]
    apart: float | None = None

    @property
    def command(self) -> str:
        """What runs it from the command line."""
        return self._inner.command

    def document(self) -> JsonObject:
        """As a daemon takes it: ``client.experiment(plan=…)``."""
        return self._inner.document()

    @property
    def _inner(self) -> settling.NextExperiment:
        return settling.NextExperiment(self.kind, deepcopy(dict(self.parameters)), self.apart)

    @property
    def _content(self) -> Hashable:
        return self.kind, settled(dict(self.parameters)), self.apart

    def __eq__(self, other: object) -> bool:
        return isinstance(other, NextExperiment) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    def __str__(self) -> str:
        return self.command


@dataclass(frozen=True, repr=False)
class Unexplained(ByKey):
    """Structure of one joint (from 1) that no effect explains. depends_on: quantities, empty where
    nobody can name them; share: of the joint's squared error; rms: of that, N·m (N)."""

    joint: int
    depends_on: tuple[str, ...]
    share: float
    rms: float
    p_value: float

    def __str__(self) -> str:
        on = f" depends on {', '.join(self.depends_on)}" if self.depends_on else ""
        return f"joint {self.joint}{on}: {100 * self.share:.0f} % of its squared error"


@dataclass(frozen=True, repr=False)
class Remaining(ByKey):
    """One joint (from 1) after all that was found. floor: N·m (N), None where it is not known, and
    floor_source, how it was found; ratio: error over floor; repeatable: does it come again with
    the motion (None: no motion does)."""

    joint: int
    rms: float
    floor: float | None
    floor_source: str | None
    ratio: float | None
    significant: bool
    material: bool | None
    repeatable: bool | None
    depends_on: tuple[str, ...]
    sentence: str

    def __str__(self) -> str:
        return self.sentence


def unexplained(document: JsonObject) -> Unexplained:
    """From a diagnosis' document."""
    return parsed(Unexplained, document)


def remaining(document: JsonObject) -> Remaining:
    """From a diagnosis' document."""
    return parsed(Remaining, document)


def next_experiment(document: JsonObject | None) -> NextExperiment | None:
    """From a finding's document."""
    if document is None:
        return None
    told = settling.NextExperiment.read(document)
    return NextExperiment(told.kind, Fixed(told.parameters), told.apart)


def confusion(document: JsonObject) -> Confusion:
    """From a finding's document."""
    return parsed(Confusion, document)
