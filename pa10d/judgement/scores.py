"""How large the error is, in the figures that people compare."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.judgement.residuals import RunResidual

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Scores:
    """Per joint (n,), over the samples by which an error is judged.

    rms      N·m, both sides through the equation's low-pass
    rms_with_reversals  N·m, the same over all motion
    rms_raw  N·m, unfiltered torque
    nrmse    rms over the range (largest minus smallest) of the filtered measured torque
    max      N·m, largest filtered error
    r2       share of the filtered torque's variance that the model explains
    """

    rms: Array
    rms_raw: Array
    nrmse: Array
    max: Array
    r2: Array
    rms_with_reversals: Array


def scores(runs: Iterable[RunResidual]) -> Scores:
    """Scores of several runs taken together: every sample counts once."""
    runs = list(runs)
    columns = [_joint_scores(runs, j) for j in range(runs[0].error.shape[1])]
    return Scores(*(np.array(row) for row in zip(*columns, strict=True)))


def moving(runs: Iterable[RunResidual], joint: int) -> list[RunResidual]:
    """The runs in which the joint moves; all of them where it moves in none."""
    runs = list(runs)
    return [run for run in runs if joint not in run.rested] or runs


def _joint_scores(runs: list[RunResidual], joint: int) -> tuple[float, ...]:
    used = moving(runs, joint)
    error = np.concatenate([run.error[run.judged[:, joint], joint] for run in used])
    torque = np.concatenate([run.measured[run.judged[:, joint], joint] for run in used])
    raw = np.concatenate([run.raw_error[run.raw_judged[:, joint], joint] for run in used])
    everywhere = np.concatenate([run.error[run.counts[:, joint], joint] for run in used])
    square = float(np.mean(error**2))
    rms = float(np.sqrt(square))
    span, spread = float(np.ptp(torque)), float(np.var(torque))
    return (
        rms,
        float(np.sqrt(np.mean(raw**2))),
        rms / span if span > 0 else 0.0,
        float(np.max(np.abs(error))),
        1.0 - square / spread if spread > 0 else 0.0,
        float(np.sqrt(np.mean(everywhere**2))),
    )
