"""The library of effects, as a list one can read."""

from __future__ import annotations

from dataclasses import dataclass

from pa10d.effects import all_effects
from pa10d.face.values import Said


@dataclass(frozen=True, repr=False)
class KnownEffect(Said):
    """An effect that a diagnosis can name. question: "missing" or "changed"."""

    id: str
    title: str
    equation: str
    question: str
    scope: str
    experiment: str

    def __str__(self) -> str:
        return f"{self.id}: {self.title} ({self.equation})"


def effects() -> tuple[KnownEffect, ...]:
    """All effects, those of other packages among them."""
    return tuple(
        KnownEffect(e.id, e.title, e.equation, e.question, e.scope, e.experiment)
        for e in all_effects().values()
    )
