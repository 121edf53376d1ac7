"""The boundary velocity of a joint: when its parameters converge, and its friction map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.figures.plotly import (
    ERROR,
    MEASURED,
    MODEL,
    NOISE,
    Figure,
    axis,
    layout,
    line,
    mark,
    packed,
)
from pa10d.paper.told import Numbers, ToldBoundary

Array = NDArray[np.float64]

USUAL = ("I", "Fc", "Fv")
UNITS = {"I": "kg·m²", "Fc": "N·m", "Fv": "N·m·s/rad"}


def convergence(found: ToldBoundary) -> Figure:
    """Estimates of equation 7 against the threshold, with their standard errors and, for the
    inertia, the band within which it is the same as that of the fast samples."""
    sweep = found.sweep
    x = _numbers(sweep.thresholds)
    data, axes = [], {}
    for row, (name, color) in enumerate(zip(USUAL, (ERROR, MODEL, NOISE), strict=True), 1):
        ref = "" if row == 1 else str(row)
        told = sweep.of(name)
        value, error = _numbers(told.value), _numbers(told.std_error)
        x_packed, y_axis = packed(x), f"y{ref}"
        data += [
            _edge(x_packed, value + 2 * error, y_axis),
            _edge(x_packed, value - 2 * error, y_axis, color),
            line(f"{name}, {UNITS[name]}", value, color, x=x_packed, yaxis=y_axis),
        ]
        top = 1.0 - (row - 1) * 0.345
        axes[f"yaxis{ref}"] = axis(
            f"{name}, {UNITS[name]}", domain=[max(top - 0.30, 0.0), top], range=_range(value)
        )
    low, high = (_numbers(edge) for edge in sweep.I_band)
    for edge in (low, high):
        data.append(
            line("band of Î", edge, MEASURED, x=packed(x), dash="dot", width=1.0, showlegend=False)
        )
    shapes = [mark(("x", y), x=found.threshold, color=MODEL) for y in ("y", "y2", "y3")]
    return {
        "data": data,
        "layout": layout(
            460, shapes=shapes, xaxis=axis("threshold, rad/s", anchor="y3"), **axes
        ),
    }  # fmt: skip


def friction_chart(found: ToldBoundary) -> Figure:
    """Friction torque against speed in both directions, and the straight line of the fast part."""
    chart = found.friction_map
    speed, level, error = (_numbers(v) for v in (chart.speed, chart.level, chart.std_error))
    forward, backward = _numbers(chart.forward), _numbers(chart.backward)
    fast = speed > max(found.threshold, found.finest)
    weight = 1.0 / error[fast]
    straight = np.polyfit(speed[fast], level[fast], 1, w=weight)
    ends = np.array([0.0, speed[-1]])
    both = [
        {"type": "scatter", "mode": "markers", "name": name, "x": packed(sign * speed),
         "y": packed(values), "marker": {"color": color, "size": 6},
         "error_y": {"type": "data", "array": packed(2 * error), "color": color,
                     "thickness": 1, "width": 2}}
        for name, sign, values, color in (
            ("forward", 1, forward, ERROR), ("backward", -1, backward, NOISE))
    ]  # fmt: skip
    lines = [
        line(
            "straight above the boundary", sign * np.polyval(straight, ends), MODEL,
            x=packed(sign * ends), showlegend=sign > 0,
        )
        for sign in (1, -1)
    ]  # fmt: skip
    threshold = found.threshold
    shapes = [mark(("x", "y"), x=at, color=MODEL) for at in (-threshold, threshold)]
    return {
        "data": [*both, *lines],
        "layout": layout(
            360, shapes=shapes, xaxis=axis("joint velocity, rad/s"), yaxis=axis("friction, N·m")
        ),
    }  # fmt: skip


def _edge(x: dict[str, str], y: Array, y_axis: str, fill: str = "") -> JsonObject:
    shaded = {"fill": "tonexty", "fillcolor": _faint(fill)} if fill else {}
    return line("", y, "rgba(0,0,0,0)", x=x, yaxis=y_axis, showlegend=False,
                hoverinfo="skip", **shaded)  # fmt: skip


def _faint(color: str) -> str:
    red, green, blue = (int(color[k : k + 2], 16) for k in (1, 3, 5))
    return f"rgba({red},{green},{blue},0.18)"


def _range(values: Array) -> list[float]:
    """All of the curve but its wildest point."""
    low, high = np.nanquantile(values, [0.02, 0.98])
    room = 0.4 * max(float(high - low), 0.02 * abs(float(high)), 1e-9)
    return [float(low - room), float(high + room)]


def _numbers(values: Numbers) -> Array:
    return np.array([np.nan if v is None else v for v in values], dtype=float)
