"""The threshold sweep: parameters of equation 7 from the samples faster than a threshold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.paper.single_joint import JointEquation
from pa10d.paper.told import ToldEstimate, ToldSweep

Array = NDArray[np.float64]

THRESHOLDS = 41
HIGHEST = 0.7  # of the peak speed: beyond, too little of the swing is left
REFERENCE = 0.45  # of the peak speed: the estimate that slower thresholds are compared with
SOFT = 0.3  # of a threshold, over which samples come to count
LEVEL = 0.99  # of the bands, all thresholds together
NAMES = ("I", "Fc", "Fv")


@dataclass(frozen=True)
class Sweep:
    """thresholds (K,) rad/s; values (K, 3) I kg·m², Fc N·m, Fv N·m·s/rad; std_errors (K, 3);
    low, high (K,) simultaneous band of I's difference from the reference threshold, around I;
    kept (K,) share of samples; converged_from rad/s, 0: from the start."""

    thresholds: Array
    values: Array
    std_errors: Array
    low: Array
    high: Array
    kept: Array
    reference: float
    converged_from: float

    def resolution(self, threshold: float) -> float:
        """rad/s between neighbouring thresholds."""
        k = int(np.searchsorted(self.thresholds, threshold))
        return float(self.thresholds[max(k, 1)] - self.thresholds[max(k, 1) - 1])

    def told(self) -> ToldSweep:
        """For whoever is told of it elsewhere."""
        columns = {
            name: ToldEstimate(tuple(self.values[:, i]), tuple(self.std_errors[:, i]))
            for i, name in enumerate(NAMES)
        }
        return ToldSweep(
            thresholds=tuple(self.thresholds),
            **columns,
            I_band=(tuple(self.low), tuple(self.high)),
            share_of_samples=tuple(self.kept),
            reference_threshold=self.reference,
            converged_from=self.converged_from,
        )


def sweep(
    data: JointEquation,
    draws: NDArray[np.int64],
    nuisance: Array,
    nuisance_draws: Array,
    material: float,
) -> Sweep:
    """draws (R, swings): how often each swing counts in each bootstrap replicate; nuisance (g,),
    nuisance_draws (R, g): constant torque and gravity, known from the friction map: a threshold
    would leave too little to tell them from inertia."""
    peak = float(np.quantile(np.abs(data.speed), 0.995))
    thresholds = np.append(0.0, np.geomspace(data.blur.min(), HIGHEST * peak, THRESHOLDS - 1))
    gram, side, count = _sums(data, thresholds)
    values = _given(gram.sum(axis=0), side.sum(axis=0), nuisance)
    many = _given(
        np.einsum("rb,bkij->rkij", draws, gram),
        np.einsum("rb,bki->rki", draws, side),
        nuisance_draws[:, None],
    )
    few = _few(len(data.runs))
    errors = few * many.std(axis=0)
    at = int(np.searchsorted(thresholds, REFERENCE * peak))
    # the band of the difference from the reference: both estimates share their fast samples
    change = values[: at + 1, 0] - values[at, 0]
    spread = many[:, : at + 1, 0] - many[:, at : at + 1, 0] - change
    sigma = few * np.maximum(spread.std(axis=0), 1e-12)
    worst = few * np.abs(spread[:, :at] / sigma[:at]).max(axis=1)
    reach = float(np.quantile(worst, LEVEL)) * sigma
    allowed = np.maximum(reach, material * abs(values[at, 0]))
    outside = np.flatnonzero(np.abs(change) > allowed)
    first = int(outside[-1]) + 1 if outside.size else 0
    first = 0 if first == 1 else first  # only what the filter smears anyway
    half = np.full(len(thresholds), np.nan)
    half[: at + 1] = reach
    return Sweep(
        thresholds,
        values[:, :3],
        errors[:, :3],
        values[:, 0] - half,
        values[:, 0] + half,
        count / count[0],
        float(thresholds[at]),
        float(thresholds[first]),
    )


def _few(swings: int) -> float:
    """A bootstrap over few swings is too narrow: degrees of freedom, and Student's for Gauss'."""
    free = max(swings - 3, 2)
    return float(np.sqrt(swings / free) * scipy.stats.t.ppf(0.975, free) / 1.96)


def _sums(data: JointEquation, thresholds: Array) -> tuple[Array, Array, Array]:
    """Normal equations per swing and threshold: (B, K, p, p), (B, K, p), and sample counts (K,).

    A sample counts by how far it is beyond the threshold, from none to all over a small share of
    it: whole samples at the edge would move an estimate of inertia by chance, the same in every
    swing.
    """
    blocks, p = len(data.runs), data.columns.shape[1]
    whole = np.column_stack([data.columns, data.tau])
    gram = np.empty((blocks, len(thresholds), p + 1, p + 1))
    count = np.empty(len(thresholds))
    for k, threshold in enumerate(thresholds):
        width = max(SOFT * threshold, 1e-12)
        weight = np.clip((np.abs(data.speed) - threshold) / width + 0.5, 0.0, 1.0)
        if k > 0:
            weight = np.where(np.abs(data.speed) < data.blur, 0.0, weight)
        count[k] = weight.sum()
        for b in range(blocks):
            rows = slice(*np.searchsorted(data.block, [b, b + 1]))
            gram[b, k] = (whole[rows] * weight[rows, None]).T @ whole[rows]
    return gram[..., :p, :p], gram[..., :p, p], count


def _given(gram: Array, side: Array, nuisance: Array) -> Array:
    """The first three unknowns (..., 3) where the others are known."""
    rest = side[..., :3] - np.einsum("...ij,...j->...i", gram[..., :3, 3:], nuisance)
    return _solve(gram[..., :3, :3], rest)


def _solve(gram: Array, side: Array) -> Array:
    """(..., p), regularised only where a bootstrap draw left too little."""
    scale = np.sqrt(np.maximum(np.einsum("...ii->...i", gram), 1e-30))
    unit = gram / (scale[..., :, None] * scale[..., None, :])
    unit = unit + 1e-10 * np.eye(gram.shape[-1])
    return np.asarray(np.linalg.solve(unit, (side / scale)[..., None])[..., 0] / scale)
