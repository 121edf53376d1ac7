"""A finished fit as a torque model, with what else is worth knowing of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pa10d.identify.cutoff import Cutoff
from pa10d.identify.feasibility import FeasibleModel
from pa10d.identify.fit import Fit
from pa10d.identify.seen import SeenRuns
from pa10d.measurement.recording import Recording
from pa10d.model import ModelNotes, TorqueModel
from pa10d.model.notes import CutoffNote, FeasibleNote


def cutoff_note(cutoff: float, why: Cutoff | None) -> CutoffNote:
    """Who chose the cut-off, and from what."""
    if why is None:
        return CutoffNote(cutoff, "user")
    return CutoffNote(
        cutoff, why.limited_by, tuple(map(float, why.signal)), tuple(map(float, why.encoder))
    )


def feasible_note(names: Sequence[str], feasible: FeasibleModel) -> FeasibleNote:
    """What goes with the feasible standard parameters: coefficients by name and rotors; and what
    they cost."""
    return FeasibleNote(
        tuple(map(float, feasible.rms)),
        dict(zip(names, map(float, feasible.coefficients), strict=True)),
        tuple(map(float, feasible.rotors)),
    )


def model_of(
    name: str,
    seen: SeenRuns,
    fit: Fit,
    feasible: FeasibleModel,
    cutoff: float,
    recordings: Sequence[Recording],
    notes: ModelNotes,
) -> TorqueModel:
    """The model of a finished fit."""
    beta, layout = fit.solution.beta, seen.layout
    terms = []
    for index, term in enumerate(layout.fitted(beta)):
        speed = term.effect.smoothed_over
        errors = {speed: float(seen.smoothing.errors[term.joints[0]])} if speed else {}
        terms.append(replace(term, shape_errors={**errors, **seen.told.get(index, {})}))
    return TorqueModel(
        name=name,
        robot=layout.robot,
        base=layout.base,
        h=layout.rigid(beta),
        terms=tuple(terms),
        covariance=fit.uncertainty.covariance,
        noise=fit.rms,
        cutoff=cutoff,
        shift=seen.shift.seconds,
        channel=None if seen.channel is None else seen.channel.passed,
        standard=feasible.standard if feasible.found else None,
        feasible=feasible.found,
        runs=tuple(r.name for r in recordings),
        notes=notes,
    )
