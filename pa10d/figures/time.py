"""Measured torque over modelled torque against time, the residual under it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.figures.decimate import extremes
from pa10d.figures.plotly import (
    ALERT,
    ERROR,
    MEASURED,
    MODEL,
    NOISE,
    Figure,
    axis,
    band,
    layout,
    line,
)
from pa10d.judgement.residuals import RunResidual
from pa10d.measurement.spans import spans

Array = NDArray[np.float64]
Span = tuple[float, float]

POINTS = 3000
SHORTEST = 0.004  # of the duration: shorter pauses are too narrow to be seen


def torque_over_time(
    run: RunResidual,
    joint: int,
    floor: float | None = None,
    *,
    raw: bool = False,
    span: Span | None = None,
    marked: NDArray[np.bool_] | None = None,
) -> Figure:
    """One joint (0-based) of one run; floor: N·m noise floor, drawn as a band of two standard
    deviations. Grey: not judged (standstill, ends of the run). Where a stretch is left out of the
    run nothing is drawn but the model: what a fit has there instead was not measured.

    raw: every sample as measured instead of both sides filtered; span: s, only that part, with as
    much detail as a screen has; marked: (M,) filtered samples to be shown in red
    """
    measured, modelled = run.measured[:, joint], run.modelled[:, joint]
    counts, dt, used = run.counts[:, joint], 1.0 / run.equation.rate, run.equation.used
    if raw:
        measured = run.equation.raw_tau[:, joint]
        modelled = measured - run.raw_error[:, joint]
        counts, dt = run.raw_counts[:, joint], run.seen.dt
        factor = run.equation.lowpass.factor
        marked = None if marked is None else np.repeat(marked, factor)[: len(counts)]
        used = np.repeat(used, factor)[: len(counts)]
    return torque_plot(
        np.where(used, measured, np.nan),
        modelled,
        dt,
        floor=None if raw else floor,
        counts=counts,
        unit=run.seen.robot.torque_unit(joint),
        span=span,
        marked=marked,
    )


def torque_plot(
    measured: Array,
    modelled: Array,
    dt: float,
    floor: float | None = None,
    counts: NDArray[np.bool_] | None = None,
    unit: str = "N·m",
    span: Span | None = None,
    marked: NDArray[np.bool_] | None = None,
) -> Figure:
    """measured, modelled: (M,) at equal steps of dt s; one cursor runs through both halves."""
    three = np.column_stack([measured, modelled, measured - modelled])
    judged = three[counts, 2] if counts is not None and counts.any() else three[:, 2]
    reach = 1.1 * max(float(np.nanmax(np.abs(judged))), 3 * (floor or 0.0), 1e-12)
    part = samples_of(span, dt, len(three))
    begin = part.start * dt
    drawn, step = extremes(three[part], POINTS)
    grid = {"x0": begin, "dx": dt * step}
    hover = {"hovertemplate": "%{y:.4g} " + unit}
    shapes = []
    if floor is not None:
        shapes.append(band(("x", "y2"), (None, None), (-2 * floor, 2 * floor), NOISE, 0.22))
    for mask, color in ((counts, MEASURED), (None if marked is None else ~marked, ALERT)):
        if mask is not None:
            shapes += [
                band(("x", ref), (begin + a, begin + b), (None, None), color, 0.16)
                for a, b in pauses(mask[part], dt)
                for ref in ("y", "y2")
            ]
    cursor = {
        "showspikes": True, "spikemode": "across", "spikesnap": "cursor", "spikethickness": 1,
        "unifiedhovertitle": {"text": "%{x:.3f} s"},
    }  # fmt: skip
    steady = {"automargin": False}  # measuring the labels is a third of drawing them
    seen = {"range": list(span)} if span else {}
    return {
        "data": [
            line("measured", drawn[:, 0], MEASURED, **grid, **hover),
            line("model", drawn[:, 1], MODEL, **grid, **hover),
            line("measured − model", drawn[:, 2], ERROR, yaxis="y2", **grid, **hover),
        ],
        "layout": layout(
            430,
            hovermode="x unified",
            hoversubplots="axis",
            shapes=shapes,
            xaxis=axis("time, s", anchor="y2", **cursor, **steady, **seen),
            yaxis=axis(f"torque, {unit}", domain=[0.42, 1.0], **steady),
            yaxis2=axis(
                f"residual, {unit}", domain=[0.0, 0.34], range=[-reach, reach], **steady
            ),
        ),
    }  # fmt: skip


def samples_of(span: Span | None, dt: float, count: int) -> slice:
    """The samples of a stretch of time and one more on either side; at least two."""
    if span is None:
        return slice(0, count)
    first = min(max(0, int(span[0] / dt)), max(0, count - 2))
    return slice(first, max(first + 2, min(count, int(span[1] / dt) + 2)))


def pauses(
    counts: NDArray[np.bool_], dt: float, shortest: float = SHORTEST
) -> list[tuple[float, float]]:
    """(begin, end) s of the stretches that do not count and are long enough to be seen."""
    least = shortest * len(counts)
    return [(float(a * dt), float(b * dt)) for a, b in spans(~counts) if b - a >= least]
