"""Judged on every other block of time, versions are fitted to all of them in the end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.sides import equation
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.delivery import delivered
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.versions import snapshot
from pa10d.judgement import RunResidual, residual_of
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel
from pa10d.regression.equation import RunEquation


def fitted_to_all(
    given: TorqueModel,
    versions: Sequence[TorqueModel],
    fit: Sequence[Recording],
    held: Sequence[RunEquation],
    none_at_least: bool = False,
) -> list[TorqueModel]:
    """The versions as they are kept: where runs were cut into blocks, half of them held out, with
    the coefficients and shapes that all of the runs give. Half of a short run may say nothing of
    directions that the other half shows.

    The held-out error of a version stays that of the fit to one half on the other: no fit to all
    has one. Its note ``delivery`` has that as promised; achieved is what the kept version leaves
    on the same blocks. given: the model that was added to; held: what was held out;
    none_at_least: of friction and rotors, as they were searched
    """
    names = {run.name for run in fit}
    if not versions or names.isdisjoint(run.name for run in held):
        return list(versions)
    passed = replace(given, channel=versions[-1].channel)  # as a search may have found it
    whole, judged = Side.of([equation(passed, run) for run in fit]), Side.of(held)
    before = [residual_of(given, run) for run in held]
    return [_one(given, one, whole, judged, before, none_at_least) for one in versions]


def _one(
    given: TorqueModel,
    version: TorqueModel,
    whole: Side,
    held: Side,
    before: Sequence[RunResidual],
    none_at_least: bool,
) -> TorqueModel:
    state = SearchState.start(version, whole, held, none_at_least=none_at_least)
    search = Search(state, (), len(given.terms))
    search.settle(rounds=1)
    made = snapshot(given, search.state, len(version.terms), before)
    promise = replace(delivered(made), promised=delivered(version).achieved)
    return replace(
        made,
        name=version.name,
        change=version.change,
        held_out=version.held_out,
        notes=replace(made.notes, delivery=promise),
    )
