"""The held-out side of a diagnosis, as each version of the model sees it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.judgement import RunResidual, residual_of

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class HeldOut:
    """seen[v][r]: version v of the diagnosis on held-out run r, as the diagnosis holds it; only the
    samples that it judged by count."""

    seen: tuple[tuple[RunResidual, ...], ...]

    def error(self, version: int, joint: int) -> Array:
        """(K,) N·m that the version leaves on the joint (0-based), all runs in a row."""
        return self.counted([run.error[:, joint] for run in self.seen[version]], joint)

    def change(self, version: int, joint: int) -> Array:
        """(K,) N·m by which the prediction moved from the version before to this one."""
        return self.error(version - 1, joint) - self.error(version, joint)

    def counted(self, per_run: Sequence[NDArray[Any]], joint: int) -> NDArray[Any]:
        """Values (M,) of each run where the joint's error counts, all runs in a row."""
        pairs = zip(per_run, self.seen[0], strict=True)
        return np.concatenate([values[run.counts[:, joint]] for values, run in pairs])

    def rms(self, version: int) -> Array:
        """(n,) N·m."""
        joints = range(self.seen[version][0].error.shape[1])
        return np.array([float(np.sqrt(np.mean(self.error(version, j) ** 2))) for j in joints])


def held_out(diagnosis: Diagnosis) -> HeldOut:
    """Predict the held-out runs with every version."""
    seen = [
        tuple(
            replace(residual_of(version, run), counts=run.keep, judged=run.keep)
            for run in diagnosis.held_out
        )
        for version in diagnosis.versions
    ]
    return HeldOut(tuple(seen))
