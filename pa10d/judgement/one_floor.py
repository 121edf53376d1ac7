"""One noise floor for all models that are judged on the same runs.

Noise is a property of the runs. What a poorer model's error has besides, and what never comes
again, looks like noise through that model and only adds to it: the least floor is the nearest. But
what noise of the angles makes is the judged model's own: one that knows of a spring makes more.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.judgement.band import in_band
from pa10d.judgement.noise import ANGLES, NoiseFloor
from pa10d.judgement.residuals import RunResidual, run_residual
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel

Array = NDArray[np.float64]


def least_floor(seen: Sequence[NoiseFloor]) -> NoiseFloor:
    """Of the same runs in the same band through several models: joint by joint the least that is
    known, with how it was found and how sure it is."""
    values = np.array([floor.values for floor in seen])
    least = np.where(np.isnan(values), np.inf, values).argmin(axis=0)
    return NoiseFloor(
        np.array([seen[k].values[j] for j, k in enumerate(least)]),
        tuple(seen[k].methods[j] for j, k in enumerate(least)),
        np.array([seen[k].errors[j] for j, k in enumerate(least)]),
        np.array([seen[k].slow[j] for j, k in enumerate(least)]),
    )


def beside_its_own(least: NoiseFloor, own: NoiseFloor) -> NoiseFloor:
    """The least floor, for a model that by itself shows ``own``: where that is what it makes of the
    angles' noise, no other model takes anything of it away."""
    made = [method == ANGLES for method in own.methods] & (own.values > least.values)
    methods = (o if m else one for m, o, one in zip(made, own.methods, least.methods, strict=True))
    return NoiseFloor(
        np.where(made, own.values, least.values),
        tuple(methods),
        np.where(made, own.errors, least.errors),
        np.where(made, own.slow, least.slow),
    )


OWN_RUNS = "the model's own runs"
"""How a floor was found that these runs do not show."""
CONTRADICTED = 1.2  # times an error: what is above it is no floor of that


def of_own_runs(models: Sequence[TorqueModel], cutoff: float) -> Array | None:
    """(n,) N·m, the least that these models know of the noise of the runs that they were identified
    from, behind the same low-pass; None where none does."""
    known = [m.notes.noise_floor for m in models if m.notes.noise_floor and m.cutoff == cutoff]
    return np.min(known, axis=0) if known else None


def or_of_own_runs(seen: NoiseFloor, known: Array | None, rms: Array) -> NoiseFloor:
    """Where runs do not show their noise, that of the model's own runs: the sensors are the same.
    Not where the error (n,) N·m contradicts that; and nobody knows how sure it is, or how much
    slower noise there is, so that no size alone speaks against it."""
    if known is None:
        return seen
    taken = np.isnan(seen.values) & (known <= CONTRADICTED * rms)
    return NoiseFloor(
        np.where(taken, np.minimum(known, rms), seen.values),
        tuple(OWN_RUNS if t else m for t, m in zip(taken, seen.methods, strict=True)),
        np.where(taken, np.nan, seen.errors),
        np.where(taken, np.inf, seen.slow),
    )


def through(
    model: TorqueModel, recordings: Sequence[Recording], cutoff: float
) -> list[RunResidual] | None:
    """The runs as a model beside the judged one sees them; None where it cannot: they may lack what
    one of its effects needs."""
    try:
        return [run_residual(in_band(model, cutoff), run) for run in recordings]
    except UserError:
        return None
