"""A map of what is left over and no effect explains: residual against one or two variables."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.unknown.structure import Structure, motion_variables
from pa10d.figures.decimate import thinned
from pa10d.figures.errors import binned
from pa10d.figures.held_out import HeldOut
from pa10d.figures.plotly import (
    ERROR,
    MODEL,
    Figure,
    Trace,
    axis,
    dots,
    layout,
    line,
    note,
    packed,
)

Array = NDArray[np.float64]

NAME = re.compile(r"(q|dq|ddq|moving)(\d+)( .*)?")
KINDS = {
    "q": ("position", "{}"),
    "dq": ("velocity", "{}/s"),
    "ddq": ("acceleration", "{}/s²"),
    "moving": ("time since the last rest", "s"),
}
CELLS = 24  # per side of the map of the held-out residual
SEEN = 4  # samples below which a cell says nothing
POINTS = 1500
# blue and orange: told apart by people who see red and green alike; the middle fades into any page
SCALE = [
    [0.0, "#2b6fb0"], [0.35, "rgba(61,143,214,0.45)"], [0.5, "rgba(138,151,166,0.10)"],
    [0.65, "rgba(232,132,44,0.45)"], [1.0, "#d06a10"],
]  # fmt: skip


def structure_map(found: Structure, seen: HeldOut) -> Figure:
    """Two variables: the map beside the held-out residual on the same axes; one: a curve."""
    error = seen.error(len(seen.seen) - 1, found.joint)
    runs = [run.equation for run in seen.seen[0]]
    motion = motion_variables(runs)
    x = [seen.counted([run[name] for run in motion], found.joint) for name in found.variables]
    robot = runs[0].context.robot
    labels = [variable_label(name, robot.prismatic) for name in found.variables]
    unit = robot.torque_unit(found.joint)
    if len(x) == 1:
        return _curve(found, x[0], error, labels[0], unit)
    return _maps(found, x, error, labels, unit)


def variable_label(name: str, prismatic: NDArray[np.bool_]) -> str:
    """``dq4`` as ``velocity of joint 4, rad/s``; ``q2 0.4 s ago`` likewise."""
    match = NAME.fullmatch(name)
    if match is None:
        return name
    length = "m" if prismatic[int(match[2]) - 1] else "rad"
    return f"{variable_words(name)}, {KINDS[match[1]][1].format(length)}"


def variable_words(name: str) -> str:
    """``velocity of joint 4``."""
    match = NAME.fullmatch(name)
    if match is None:
        return name
    return f"{KINDS[match[1]][0]} of joint {match[2]}{' about' + match[3] if match[3] else ''}"


def _curve(found: Structure, x: Array, error: Array, label: str, unit: str) -> Figure:
    chosen = thinned(len(x), POINTS)
    middle, rows = binned(x, error)
    data: list[Trace] = [
        dots("held-out residual", x[chosen], error[chosen], ERROR),
        line("its mean", rows[:, 1], ERROR, x=packed(middle), width=2.2),
        line("the map", found.values, MODEL, x=packed(found.grid[0]), width=3),
    ]
    figure = layout(340, xaxis=axis(label), yaxis=axis(f"residual, {unit}"))
    return {"data": data, "layout": figure}


def _maps(found: Structure, x: list[Array], error: Array, labels: list[str], unit: str) -> Figure:
    edges = [np.linspace(v.min(), v.max(), CELLS + 1) for v in x]
    counts = np.histogram2d(x[0], x[1], edges)[0]
    sums = np.histogram2d(x[0], x[1], edges, weights=error)[0]
    mean = np.where(counts >= SEEN, sums / np.maximum(counts, 1), np.nan)
    limit = float(np.nanmax(np.abs([np.nanmax(np.abs(mean)), np.abs(found.values).max()])))
    shared = {"zmin": -limit, "zmax": limit, "colorscale": SCALE}
    hover = "%{x:.3g}, %{y:.3g}: %{z:.3g} " + unit + "<extra></extra>"
    data: list[Trace] = [
        {
            "type": "heatmap", "x": packed(found.grid[0]), "y": packed(found.grid[1]),
            "z": _rows(found.values.T), "zsmooth": "best", "hovertemplate": hover,
            "showscale": False, **shared,
        },
        {
            "type": "heatmap", "x": packed(_middles(edges[0])), "y": packed(_middles(edges[1])),
            "z": _rows(mean.T), "hovertemplate": hover, "xaxis": "x2", "yaxis": "y2",
            "colorbar": {"title": {"text": unit}, "thickness": 12, "outlinewidth": 0}, **shared,
        },
    ]  # fmt: skip
    figure = layout(
        390,
        xaxis=axis(labels[0], domain=[0, 0.45]),
        yaxis=axis(labels[1]),
        xaxis2=axis(labels[0], domain=[0.55, 1.0], anchor="y2", matches="x"),
        yaxis2=axis("", anchor="x2", matches="y"),
        annotations=[
            note("learnt from the fitted data", 0.0, 1.0, yanchor="bottom", xanchor="left"),
            note("what the held-out data show", 0.55, 1.0, yanchor="bottom", xanchor="left"),
        ],
    )
    return {"data": data, "layout": figure}


def _rows(values: Array) -> list[list[float | None]]:
    return [[round(float(v), 6) if np.isfinite(v) else None for v in row] for row in values]


def _middles(edges: Array) -> Array:
    return np.asarray(0.5 * (edges[1:] + edges[:-1]))
