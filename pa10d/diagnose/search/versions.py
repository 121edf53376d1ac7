"""The models that a search has made, one per addition: what was judged is what is stored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pa10d.diagnose.evidence.errors_of import scales_of
from pa10d.diagnose.evidence.stated import stated
from pa10d.diagnose.evidence.tails import tails, with_open
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.delivery import delivery
from pa10d.diagnose.search.first_terms import with_first
from pa10d.diagnose.search.harm import rms
from pa10d.identify.feasibility import nearest_feasible
from pa10d.identify.outcome import feasible_note
from pa10d.judgement import RunResidual, noise_floor, residual_of
from pa10d.model import Term, TorqueModel, vector_of
from pa10d.regression.told import added_ones, left_open, names_of


def versions_of(
    given: TorqueModel, state: SearchState, count: int, as_given: Sequence[RunResidual]
) -> tuple[TorqueModel, ...]:
    """One model per addition, each with its errors on the same held-out data and, unless it is not
    refitted, with the possible bodies nearest to its own.

    as_given: the held-out side as the given model saw it, before anything was refitted
    """
    sizes = range(count, len(state.terms) + 1)
    return tuple(snapshot(given, state, size, as_given) for size in sizes)


def held_out(model: TorqueModel, state: SearchState) -> list[RunResidual]:
    """The held-out side as a model sees it."""
    return [residual_of(model, run) for run in state.held.everywhere.runs]


def snapshot(
    given: TorqueModel,
    state: SearchState,
    size: int,
    as_given: Sequence[RunResidual],
    of_law: bool = True,
) -> TorqueModel:
    """The model with the first ``size`` terms, as the search fitted and judged it. Its note
    ``delivery`` has what the search promised and what the model as it is stored achieves. of_law:
    whether its errors know that one law of an effect may as well be another."""
    part = state if size == len(state.terms) else with_first(state, size, given.terms)
    part = part.where_shared_slips()
    refitted = size == len(given.terms)
    frozen = state.frozen
    known = stated(part, found_here(part, len(given.terms)), of_law)
    terms = [
        replace(term, shape_errors=known.shape_errors.get(index, _errors_before(part, term)))
        for index, term in enumerate(part.terms)
    ]
    judged_on = tuple(dict.fromkeys(run.name for run in part.held.runs))
    notes = replace(given.notes, warnings=(), delivery=None, judged_on=judged_on)
    if not frozen:  # fitted to the data alone, and perhaps to others
        same = {run.name for run in part.train.runs} <= set(given.runs)
        notes = replace(notes, feasible=None, noise_floor=None, prior=None, left_out=None)
        notes = notes if same else replace(notes, open=())
    model = replace(
        part.model,
        terms=tuple(terms),
        covariance=known.covariance,
        noise=np.where(part.fit.rows, part.fit.rms(), given.noise),
        shift=part.train.runs[0].shift,
        standard=given.standard if frozen else None,
        feasible=given.feasible and frozen,
        change="given model, refitted" if refitted else f"added {terms[-1].label}",
        parent=given.name,
        runs=tuple(dict.fromkeys(run.name for run in part.train.runs)),
        notes=notes,
    )
    seen = held_out(model, state)
    promise = delivery(rms(part.held_residual()), as_given, seen, part.held.silent)
    model = replace(
        model,
        held_out={"held out": np.array(promise.achieved)},
        notes=replace(model.notes, delivery=promise),
    )
    if not frozen:
        model = replace(model, notes=replace(model.notes, noise_floor=_own_noise(model, part)))
    model = with_open(_with_open(model, part), unseen(model, part, len(given.terms)))
    return model if frozen else _with_bodies(model, part)


def _own_noise(model: TorqueModel, part: SearchState) -> tuple[float, ...] | None:
    """(n,) N·m of the runs that it was fitted to, as it sees them: through what it was made from it
    was more. None where they do not show it of all joints."""
    runs = part.train.everywhere.runs
    floor = noise_floor([residual_of(model, run) for run in runs]).values
    return tuple(floor.tolist()) if np.all(np.isfinite(floor)) else None


def found_here(part: SearchState, given: int) -> list[int]:
    """Terms whose shapes are estimates of these data: what a frozen model had stays as it was,
    and of the textbook's terms identification says how sure their shapes are."""
    return [
        index
        for index, term in enumerate(part.terms)
        if (index >= given and part.same_before(term.effect, term.joints) is None)
        or (index < given and not (part.frozen or term.effect.question == "textbook"))
    ]


def _errors_before(part: SearchState, term: Term) -> dict[str, float]:
    """Of a shape that these data did not settle: the term's own, or of what is there already."""
    before = part.same_before(term.effect, term.joints)
    return term.shape_errors if before is None else before.shape_errors


def unseen(model: TorqueModel, part: SearchState, given: int) -> dict[str, str]:
    """Of the terms that were added: which the fit saw no more than a tail of, and a line each."""
    added = model.terms[given:]
    return tails(model, added, part.train.runs) if added else {}


def _with_open(model: TorqueModel, part: SearchState) -> TorqueModel:
    """What the fit leaves open, besides what the given model's own fit did not see at all."""
    values = vector_of(model.h, model.terms)
    added = added_ones(len(model.h), model.terms)
    scales = scales_of(part, part.matrix(0))
    found = names_of(model.parameter_names(), left_open(values, model.std_errors, *scales, added))
    return replace(model, notes=model.notes.with_open(found))


def _with_bodies(model: TorqueModel, part: SearchState) -> TorqueModel:
    bodies = nearest_feasible(
        part.fit.triangle, part.fit.target, part.unknowns, model.robot, part.rms_of
    )
    names = model.parameter_names()[len(model.h) :]
    return replace(
        model,
        standard=bodies.standard if bodies.found else None,
        feasible=bodies.found,
        notes=replace(model.notes, feasible=feasible_note(names, bodies)),
    )
