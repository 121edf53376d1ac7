"""What a search ends with: a version of the model per step, and what the last of them leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.begun import Begun
from pa10d.diagnose.search.versions import held_out, versions_of
from pa10d.judgement import (
    Judgement,
    Repeatable,
    RunResidual,
    judged,
    of_own_runs,
    repeatable,
    with_known_floor,
    with_one_floor,
)
from pa10d.model import TorqueModel


@dataclass(frozen=True, eq=False)
class Finished:
    """versions: one per step, the given model (refitted unless frozen) first; first, seen: the
    held-out side as the first and the last of them see it; left: how the last is judged there, with
    the least floor that any of them shows; again: (n) what comes again of its error."""

    versions: tuple[TorqueModel, ...]
    first: list[RunResidual]
    seen: list[RunResidual]
    left: Judgement
    again: Sequence[Repeatable | None]


def finished(begun: Begun, state: SearchState) -> Finished:
    """state: as the search left it."""
    versions = versions_of(begun.model, state, begun.given, begun.as_given)
    views = [begun.as_given, *(held_out(version, state) for version in versions)]
    known = of_own_runs([begun.whole, *versions], begun.model.cutoff)
    alike = with_one_floor([judged(versions[-1].name, view) for view in views])
    return Finished(
        versions=versions,
        first=views[0] if state.frozen else views[1],
        seen=views[-1],
        left=with_known_floor(alike[-1], known),
        again=repeatable(views[-1]),
    )
