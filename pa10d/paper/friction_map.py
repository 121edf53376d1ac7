"""Velocity against friction torque, and the speed at which its straight part begins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.paper.single_joint import JointEquation
from pa10d.paper.told import ToldMap

Array = NDArray[np.float64]

BINS = 28
LEAST_BIN = 0.004  # of the peak speed: where the finest bin begins, unless the filter blurs more
STRAIGHT = 5  # fastest bins that are never taken away
PRICE = 8.0  # of χ² for leaving out a bin: by chance in one of 200
BELIEF = 0.35  # of the peak speed: the line must be held by at least this range of speeds


@dataclass(frozen=True)
class FrictionMap:
    """edges (m+1,) rad/s of bins of |q̇|; forward, backward (m,) N·m, mean friction torque in either
    direction; level (m,) N·m, half their difference, std_error (m,); replicates (R, m) of level;
    nuisance (g,) constant torque and gravity, fitted along, and its replicates (R, g)."""

    edges: Array
    speed: Array
    forward: Array
    backward: Array
    level: Array
    std_error: Array
    replicates: Array
    nuisance: Array
    nuisance_replicates: Array

    def told(self) -> ToldMap:
        """For whoever is told of it elsewhere."""
        return ToldMap(
            speed=tuple(self.speed),
            forward=tuple(self.forward),
            backward=tuple(self.backward),
            level=tuple(self.level),
            std_error=tuple(self.std_error),
            edges=tuple(self.edges),
        )


def friction_map(data: JointEquation, draws: NDArray[np.int64]) -> FrictionMap:
    """What is left of the torque without inertia, bias and gravity, by speed.

    Inertia, bias and gravity are fitted together with a free friction level in every bin, so that
    nothing is assumed about friction but that it depends on speed.
    """
    size = np.abs(data.speed)
    peak = float(np.quantile(size, 0.995))
    finest = max(LEAST_BIN * peak, float(data.blur.min()))
    edges = np.geomspace(finest, peak * 1.0001, BINS + 1)
    slot = np.searchsorted(edges, size, side="right") - 1
    inside = (slot >= 0) & (slot < BINS) & (size >= data.blur)
    columns = np.delete(data.columns[inside], [1, 2], axis=1)
    slot, tau, block = slot[inside], data.tau[inside], data.block[inside]
    sign, speed = np.sign(data.speed[inside]), size[inside]
    blocks, p = int(data.block.max()) + 1, columns.shape[1] + BINS
    # within a bin friction follows its speed: the mean speed is what the level belongs to
    centre = np.bincount(slot, speed, BINS) / np.maximum(np.bincount(slot, minlength=BINS), 1)
    gram, side = np.zeros((blocks, p, p)), np.zeros((blocks, p))
    for b in range(blocks):
        rows = block == b
        design = np.zeros((int(rows.sum()), p))
        design[:, : p - BINS] = columns[rows]
        design[np.arange(len(design)), p - BINS + slot[rows]] = sign[rows]
        gram[b], side[b] = design.T @ design, design.T @ tau[rows]
    found = _solve(gram.sum(axis=0), side.sum(axis=0))
    times = draws.astype(float)
    many = _solve(np.tensordot(times, gram, 1), times @ side)
    rest = tau - columns @ found[: p - BINS]
    forward, backward = (
        np.bincount(slot[way], rest[way], BINS)
        / np.maximum(np.bincount(slot[way], minlength=BINS), 1)
        for way in (sign > 0, sign < 0)
    )
    level, replicates = found[p - BINS :], many[:, p - BINS :]
    count = np.bincount(slot, minlength=BINS)
    used = count > 0
    # few swings scatter by chance too little: never less than their own noise makes of them
    left = rest - sign * level[slot]
    least = np.sqrt(np.mean(left**2) / np.maximum(count * data.independent, 1.0))
    error = np.maximum(replicates.std(axis=0), least)
    return FrictionMap(
        np.append(edges[:-1][used], edges[-1]),
        centre[used],
        forward[used],
        backward[used],
        level[used],
        np.maximum(error[used], 1e-9),
        replicates[:, used],
        found[1 : p - BINS],
        many[:, 1 : p - BINS],
    )


def knee(chart: FrictionMap, material: float, level: Array | None = None) -> int:
    """How many of the slowest bins the line through the faster ones does not explain.

    Each bin that is left out frees one parameter and must lower the misfit by more than its price.
    A bin's variance is that between swings plus what is immaterial.
    """
    values = chart.level if level is None else level
    m = len(values)
    line = np.column_stack([np.ones(m), chart.speed])
    fast = chart.speed >= BELIEF * chart.speed[-1]
    coulomb = abs(float(np.linalg.lstsq(line[fast], values[fast], rcond=None)[0][0]))
    sigma = np.hypot(chart.std_error, material * coulomb)
    scaled, target = line / sigma[:, None], values / sigma
    most = min(m - STRAIGHT, int(np.argmax(fast)))
    costs = []
    for k in range(max(most, 0) + 1):
        left = np.linalg.lstsq(scaled[k:], target[k:], rcond=None)[0]
        misfit = float(np.sum((target[k:] - scaled[k:] @ left) ** 2))
        costs.append(misfit + k * PRICE)
    return int(np.argmin(costs))


def knee_spread(chart: FrictionMap, material: float) -> Array:
    """(R,) the threshold in every bootstrap replicate."""
    # a replicate scatters around the estimate as the estimate does around the truth
    return np.array([chart.edges[knee(chart, material, row)] for row in chart.replicates])


def _solve(gram: Array, side: Array) -> Array:
    scale = np.sqrt(np.maximum(np.einsum("...ii->...i", gram), 1e-30))
    unit = gram / (scale[..., :, None] * scale[..., None, :]) + 1e-10 * np.eye(gram.shape[-1])
    return np.asarray(np.linalg.solve(unit, (side / scale)[..., None])[..., 0] / scale)
