"""One noise floor for all models that are judged on the same runs.

Noise is a property of the runs. What a poorer model's error has besides, and what never comes
again, looks like noise through that model and only adds to it: the least floor is the nearest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.common.errors import UserError
from pa10d.judgement.band import in_band
from pa10d.judgement.noise import NoiseFloor
from pa10d.judgement.residuals import RunResidual, run_residual
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel


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


def through(
    model: TorqueModel, recordings: Sequence[Recording], cutoff: float
) -> list[RunResidual] | None:
    """The runs as a model beside the judged one sees them; None where it cannot: they may lack what
    one of its effects needs."""
    try:
        return [run_residual(in_band(model, cutoff), run) for run in recordings]
    except UserError:
        return None
