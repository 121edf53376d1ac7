"""The models that a search has made: one per addition, as it saw them and as they are stored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pa10d.diagnose.errors_of import full_covariance, term_covariance
from pa10d.diagnose.search import rms
from pa10d.diagnose.settled import Settled
from pa10d.diagnose.state import State
from pa10d.identify.feasibility import nearest_feasible
from pa10d.identify.outcome import feasible_note
from pa10d.model import TorqueModel


def versions_of(given: TorqueModel, state: State, count: int) -> tuple[TorqueModel, ...]:
    """One model per addition, each with its errors on the same held-out data."""
    return tuple(snapshot(given, state, size) for size in range(count, len(state.terms) + 1))


def to_store(state: State, versions: Sequence[TorqueModel]) -> tuple[TorqueModel, ...]:
    """The versions with the coefficients that they are stored with, and the possible bodies nearest
    to these; a model that is not refitted stays as it is."""
    if state.prior is not None:
        return tuple(versions)
    settled = Settled.of(state)
    return tuple(_settled(state, settled, version) for version in versions)


def _settled(state: State, settled: Settled, version: TorqueModel) -> TorqueModel:
    count = len(version.covariance)
    solution = settled.solution(count)
    beta = solution.beta
    start, terms = len(version.h), []
    for term in version.terms:
        stop = start + len(term.coefficients)
        terms.append(replace(term, coefficients=beta[start:stop]))
        start = stop
    left = {j: state.held.tau[j] - c[:, :count] @ beta for j, c in state.held_matrix.items()}
    bounded = [c for term in terms for c in term.effect.coefficients]
    bodies = nearest_feasible(solution, version.base, version.robot, bounded, settled.rms)
    names = version.parameter_names()[len(version.h) :]
    return replace(
        version,
        h=beta[: len(version.h)],
        terms=tuple(terms),
        standard=bodies.standard if bodies.found else None,
        feasible=bodies.found,
        held_out={"held out": rms(left)},
        notes={**version.notes, "feasible": feasible_note(names, bodies)},
    )


def snapshot(given: TorqueModel, state: State, size: int) -> TorqueModel:
    """The model with the first ``size`` terms, as the search sees it. The bodies of a model that is
    not refitted remain what they were; others are sought when it is stored."""
    part = state if size == len(state.terms) else state.bare(size, own_weights=True)
    refitted = size == len(given.terms)
    terms = []
    for index, term in enumerate(part.terms):
        errors: dict[str, float] = dict(term.shape_errors)
        if index >= len(given.terms) and term.shape:
            errors = term_covariance(part, index)[1]
        terms.append(replace(term, shape_errors=errors))
    frozen = state.prior is not None
    lost = ("warnings",) if frozen else ("warnings", "feasible")
    notes = {k: v for k, v in given.notes.items() if k not in lost}
    return replace(
        part.model,
        terms=tuple(terms),
        covariance=full_covariance(part),
        noise=part.fit.rms(),
        shift=part.train.runs[0].shift,
        standard=given.standard if frozen else None,
        feasible=given.feasible and frozen,
        change="given model, refitted" if refitted else f"added {terms[-1].label}",
        parent=given.name,
        runs=tuple(dict.fromkeys(run.name for run in part.train.runs)),
        held_out={"held out": rms(part.held_residual())},
        notes=notes,
    )
