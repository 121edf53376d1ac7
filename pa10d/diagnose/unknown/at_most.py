"""How much of an error may be noise, where nobody knows its floor: hardly more than the same model
leaves on the runs that it was fitted to, for noise is in there, too."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.regression.sides import independent
from pa10d.diagnose.regression.state import SearchState

Array = NDArray[np.float64]


def most_noise(state: SearchState) -> Array:
    """(n,) N·m RMS; what coefficients took along of it is added, inf where that may be all. A
    frozen model was fitted to runs of its own."""
    if state.frozen:
        return state.model.noise
    samples = np.maximum(independent(state.train.runs), 1.0)
    kept = 1.0 - state.fit.leverage() / samples
    return np.where(kept > 0.0, state.fit.rms() / np.sqrt(np.maximum(kept, 1e-12)), np.inf)
