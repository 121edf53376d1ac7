"""The held-out side of a diagnosis, as each version of the model sees it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.compare import RunResidual, run_residual
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.sides import two_sides
from pa10d.measurement.recording import Recording

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class HeldOut:
    """seen[v][r]: version v of the diagnosis on held-out run r; only the samples that the diagnosis
    judged by count. side: the same runs as the diagnosis holds them."""

    side: Side
    seen: tuple[tuple[RunResidual, ...], ...]

    def error(self, version: int, joint: int) -> Array:
        """(K,) N·m that the version leaves on the joint (0-based), all runs in a row."""
        return self.counted([run.error[:, joint] for run in self.seen[version]], joint)

    def change(self, version: int, joint: int) -> Array:
        """(K,) N·m by which the prediction moved from the version before to this one."""
        pairs = zip(self.seen[version], self.seen[version - 1], strict=True)
        return self.counted([a.modelled[:, joint] - b.modelled[:, joint] for a, b in pairs], joint)

    def counted(self, per_run: Sequence[Array], joint: int) -> Array:
        """Values (M,) of each run where the joint's error counts, all runs in a row."""
        pairs = zip(per_run, self.seen[0], strict=True)
        return np.concatenate([values[run.counts[:, joint]] for values, run in pairs])

    def rms(self, version: int) -> Array:
        """(n,) N·m."""
        joints = range(self.side.n)
        return np.array([float(np.sqrt(np.mean(self.error(version, j) ** 2))) for j in joints])


def held_out(
    diagnosis: Diagnosis, fit: Sequence[Recording], validate: Sequence[Recording] = ()
) -> HeldOut:
    """Predict the held-out runs with every version; fit, validate: as the diagnosis had them."""
    side = two_sides(diagnosis.versions[0], fit, validate)[1]
    fitted = {recording.name for recording in fit}
    # in the order of two_sides: runs of the held-out side alone come first
    runs = sorted(validate, key=lambda r: r.name in fitted) if validate else list(fit)
    seen = [
        tuple(
            replace(run_residual(version, recording), counts=keep, judged=keep)
            for recording, keep in zip(runs, side.keep, strict=True)
        )
        for version in diagnosis.versions
    ]
    return HeldOut(side, tuple(seen))
