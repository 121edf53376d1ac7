"""Evidence over time, over frequency and over order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.compare import RunResidual
from pa10d.compare.orders import order_spectrum
from pa10d.figures.decimate import extremes, peaks
from pa10d.figures.plotly import (
    ERROR,
    MEASURED,
    MODEL,
    NOISE,
    Figure,
    axis,
    band,
    layout,
    line,
    mark,
    note,
    packed,
)

Array = NDArray[np.float64]

STRETCH = 12.0  # s that are shown
POINTS = 3000


def over_time(
    before: Sequence[RunResidual], after: Sequence[RunResidual], joint: int, floor: float | None
) -> Figure:
    """The stretch of time in which the effect acts most: above, the residual without it and what
    it explains; below, what is left with it. before, after: the same runs."""
    changes = [
        np.where(b.counts[:, joint], b.error[:, joint] - a.error[:, joint], 0.0)
        for b, a in zip(before, after, strict=True)
    ]
    k, cut = strongest(changes, [run.equation.rate for run in before])
    run, counts = before[k], before[k].counts[cut, joint]
    t = run.equation.t[cut]
    without = np.where(counts, run.error[cut, joint], np.nan)
    rest = np.where(counts, after[k].error[cut, joint], np.nan)
    span = _span(without, rest, floor)
    low = {"xaxis": "x", "yaxis": "y2"}
    data = [
        line("residual without it", without, MEASURED, x=packed(t, True), width=4),
        line("what it explains", np.where(counts, changes[k][cut], np.nan), MODEL,
             x=packed(t, True), width=1.8),
        line("residual with it", rest, ERROR, x=packed(t, True), **low),
    ]  # fmt: skip
    shapes = []
    if floor is not None:
        shapes = [
            band(pair, (None, None), (-2 * floor, 2 * floor), NOISE, 0.2)
            for pair in (("x", "y"), ("x", "y2"))
        ]
    unit = run.seen.robot.torque_unit(joint)
    figure = layout(
        330,
        shapes=shapes,
        xaxis=axis(f"time in run {run.name}, s", anchor="y2"),
        yaxis=axis(f"joint {joint + 1}, {unit}", domain=[0.53, 1.0], range=span),
        yaxis2=axis("with it", domain=[0.0, 0.46], range=span),
    )
    return {"data": data, "layout": figure}


def strongest(changes: Sequence[Array], rates: Sequence[float]) -> tuple[int, slice]:
    """Run and stretch of STRETCH seconds in which the change varies most."""
    best, where = -1.0, (0, slice(None))
    for k, (change, rate) in enumerate(zip(changes, rates, strict=True)):
        length = min(len(change), max(2, round(STRETCH * rate)))
        sums = _moving(change**2, length) - _moving(change, length) ** 2 / length
        start = int(np.argmax(sums))
        if sums[start] > best:
            best, where = float(sums[start]), (k, slice(start, start + length))
    return where


def _moving(values: Array, length: int) -> Array:
    total = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(total[length:] - total[:-length])


def _span(without: Array, rest: Array, floor: float | None) -> list[float]:
    """An axis that holds both, zero and the noise."""
    shown = np.concatenate([without, rest])
    shown = shown[np.isfinite(shown)]
    least = 3.0 * floor if floor is not None else 0.0
    low, high = min(float(shown.min()), -least), max(float(shown.max()), least)
    return [low - 0.06 * (high - low), high + 0.06 * (high - low)]


def over_frequency(
    before: Sequence[RunResidual], after: Sequence[RunResidual], joint: int, cutoff: float
) -> Figure:
    """Amplitude density of what is left without and with the effect, Hz."""
    data = []
    for name, runs, color in (("without it", before, MEASURED), ("with it", after, ERROR)):
        f, density = density_of(runs, joint)
        f, density = peaks(f, density, POINTS)
        data.append(line(name, density, color, x=packed(f), width=2))
    unit = before[0].seen.robot.torque_unit(joint)
    figure = layout(
        330,
        xaxis=axis("frequency, Hz", range=[0, 1.3 * cutoff]),
        yaxis=axis(f"residual of joint {joint + 1}, {unit}/√Hz", type="log", dtick="D2"),
        shapes=[mark(("x", "y"), x=cutoff, color=NOISE)],
    )
    return {"data": data, "layout": figure}


def density_of(runs: Sequence[RunResidual], joint: int) -> tuple[Array, Array]:
    """Hz, and the amplitude density of the counted residual over all runs, N·m/√Hz."""
    power, frequency = [], np.empty(0)
    length = min(len(run.measured) for run in runs)
    length = min(length, max(64, round(8.0 * runs[0].equation.rate)))
    for run in runs:
        values = np.where(run.counts[:, joint], run.error[:, joint], 0.0)
        share = max(float(run.counts[:, joint].mean()), 1e-9)
        frequency, density = scipy.signal.welch(values, run.equation.rate, nperseg=length)
        power.append(density / share)
    return frequency[1:], np.sqrt(np.mean(power, axis=0))[1:]


def over_order(
    before: Sequence[RunResidual], after: Sequence[RunResidual], joint: int
) -> Figure | None:
    """What is left without and with the effect in cycles per revolution; None where the joint
    turns too little for that."""
    first, second = order_spectrum(before, joint), order_spectrum(after, joint)
    if first is None or second is None:
        return None
    data = []
    for name, found, color in (("without it", first, MEASURED), ("with it", second, ERROR)):
        n, size = peaks(found.order, found.amplitude, POINTS)
        data.append(line(name, size, color, x=packed(n), width=1.8))
    n, level = extremes(np.column_stack([first.order, first.threshold]), POINTS)[0].T
    data.append(line("level that noise does not pass", level, NOISE, x=packed(n), dash="dash"))
    unit = before[0].seen.robot.torque_unit(joint)
    figure = layout(
        330,
        xaxis=axis(f"cycles per revolution of joint {joint + 1}", rangemode="tozero"),
        yaxis=axis(f"residual, {unit}", rangemode="tozero"),
        annotations=[
            note(f"{order:.4g}", order, size, xref="x", yref="y", yanchor="bottom", yshift=4)
            for order, size in first.lines[:2]
        ],
    )
    return {"data": data, "layout": figure}
