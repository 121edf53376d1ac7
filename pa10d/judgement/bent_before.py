"""Where a run's beginning still shows: friction as it was before anybody looked.

A joint that stands as its recording begins may stand on bristles that are bent either way, by all
that they carry or not at all: no motion says. Until it has slid some ways of theirs their friction
is not the model's to know, and an error there is none of its own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.effects.context import Context
from pa10d.measurement.signals import Lowpass
from pa10d.regression.per_joint import Mask

FORGOTTEN = 5.0  # ways: less than a hundredth is left of how they were bent (exp(-5))


def bent_before(seen: Context, lowpass: Lowpass) -> Mask:
    """(M, n) True where a joint's bristles are bent as the run found them, or the low-pass still
    knows of it. seen: the run's motion, with the model's ways."""
    first = np.zeros(seen.q.shape, dtype=bool)
    for joint, way in enumerate(seen.ways):
        if way > 0.0:
            far = way * seen.stretched(joint)
            slid = np.cumsum(np.abs(np.diff(seen.q[:, joint], prepend=seen.q[0, joint])) / far)
            first[:, joint] = slid < FORGOTTEN
    factor = lowpass.factor
    known_from = np.ceil(first.sum(axis=0) / factor).astype(np.int64)
    reach = np.where(known_from > 0, known_from + lowpass.settle, 0)
    samples: NDArray[np.int64] = np.arange(lowpass.kept)
    return np.asarray(samples[:, None] < reach)
