"""Measured torque over modelled torque against time, the residual under it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.compare.residuals import RunResidual
from pa10d.figures.decimate import extremes
from pa10d.figures.plotly import ERROR, MEASURED, MODEL, NOISE, Figure, axis, band, layout, line

Array = NDArray[np.float64]

POINTS = 3000
SHORTEST = 0.004  # of the duration: shorter pauses are too narrow to be seen


def torque_over_time(run: RunResidual, joint: int, floor: float | None = None) -> Figure:
    """One joint (0-based) of one run, filtered; floor: N·m noise floor, drawn as a band of two
    standard deviations. Grey: not judged (standstill, ends of the run)."""
    prismatic = bool(run.seen.robot.prismatic[joint])
    return torque_plot(
        run.measured[:, joint],
        run.modelled[:, joint],
        1.0 / run.equation.rate,
        floor=floor,
        counts=run.counts[:, joint],
        unit="N" if prismatic else "N·m",
    )


def torque_plot(
    measured: Array,
    modelled: Array,
    dt: float,
    floor: float | None = None,
    counts: NDArray[np.bool_] | None = None,
    unit: str = "N·m",
) -> Figure:
    """measured, modelled: (M,) at equal steps of dt s; one cursor runs through both halves."""
    three = np.column_stack([measured, modelled, measured - modelled])
    drawn, step = extremes(three, POINTS)
    grid = {"x0": 0.0, "dx": dt * step}
    hover = {"hovertemplate": "%{y:.4g} " + unit}
    judged = three[counts, 2] if counts is not None and counts.any() else three[:, 2]
    reach = 1.1 * max(float(np.max(np.abs(judged))), 3 * (floor or 0.0), 1e-12)
    shapes = []
    if floor is not None:
        shapes.append(band(("x", "y2"), (None, None), (-2 * floor, 2 * floor), NOISE, 0.22))
    if counts is not None:
        shapes += [
            band(("x", ref), span, (None, None), MEASURED, 0.16)
            for span in pauses(counts, dt)
            for ref in ("y", "y2")
        ]
    cursor = {
        "showspikes": True, "spikemode": "across", "spikesnap": "cursor", "spikethickness": 1,
        "unifiedhovertitle": {"text": "%{x:.3f} s"},
    }  # fmt: skip
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
            xaxis=axis("time, s", anchor="y2", **cursor),
            yaxis=axis(f"torque, {unit}", domain=[0.42, 1.0]),
            yaxis2=axis(f"residual, {unit}", domain=[0.0, 0.34], range=[-reach, reach]),
        ),
    }  # fmt: skip


def pauses(counts: NDArray[np.bool_], dt: float) -> list[tuple[float, float]]:
    """(begin, end) s of the stretches that do not count and are long enough to be seen."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (~counts).astype(np.int8), [0]])))
    least = SHORTEST * len(counts)
    return [
        (float(a * dt), float(b * dt))
        for a, b in zip(edges[::2], edges[1::2], strict=True)
        if b - a >= least
    ]
