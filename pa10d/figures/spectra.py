"""The residual against order (cycles per revolution) and against frequency, side by side."""

from __future__ import annotations

import numpy as np

from pa10d.common.jsonable import JsonObject
from pa10d.compare.frequencies import FrequencySpectrum
from pa10d.compare.orders import OrderSpectrum
from pa10d.figures.decimate import peaks
from pa10d.figures.plotly import (
    ALERT,
    ERROR,
    MEASURED,
    NOISE,
    Figure,
    axis,
    layout,
    line,
    mark,
    note,
    packed,
)

POINTS = 1200
SHOWN = 1.6  # times the highest line's order, and at least LEAST
LEAST = 120.0  # cycles/rev


def spectra(
    order: OrderSpectrum | None, frequency: FrequencySpectrum, cutoff: float, unit: str = "N·m"
) -> Figure:
    """Left: amplitude per order with the level noise does not pass and the lines above it.
    Right: power density of the error and of the measured torque, with the fit's cut-off, Hz."""
    f, error = peaks(frequency.frequency, frequency.error, POINTS)
    g, torque = peaks(frequency.frequency, frequency.torque, POINTS)
    right = {"xaxis": "x2", "yaxis": "y2"}
    hover = "%{x:.3g} Hz: %{y:.3g}"
    data = [
        line("measured torque", torque, MEASURED, x=packed(g), hovertemplate=hover, **right),
        line("residual", error, ERROR, x=packed(f), hovertemplate=hover, **right),
    ]
    annotations = [
        note(title, x, 1.0, yanchor="bottom", xanchor="left")
        for title, x in (("order spectrum", 0.0), ("frequency spectrum", 0.55))
    ]
    figure = layout(
        340,
        xaxis=axis("order, cycles per revolution", domain=[0, 0.45], rangemode="tozero"),
        yaxis=axis(f"amplitude, {unit}", rangemode="tozero"),
        xaxis2=axis("frequency, Hz", domain=[0.55, 1.0], anchor="y2", type="log", dtick=1),
        yaxis2=axis(
            f"density, {unit}/√Hz", anchor="x2", type="log", dtick=1, exponentformat="power"
        ),
        shapes=[mark(("x2", "y2"), x=cutoff, color=NOISE)],
        annotations=annotations,
        showlegend=True,
    )
    figure["margin"] |= {"t": 58}
    figure["legend"] |= {"y": 1.09}
    if order is None:
        annotations.append(note("the joint turns too little", 0.225, 0.5))
    else:
        data += _orders(order, unit, annotations)
        highest = max((n for n, _ in order.lines), default=0.0)
        figure["xaxis"]["range"] = [0, float(min(max(LEAST, SHOWN * highest), order.order[-1]))]
    return {"data": data, "layout": figure}


def _orders(found: OrderSpectrum, unit: str, annotations: list[JsonObject]) -> list[dict]:
    n, size = peaks(found.order, found.amplitude, 2 * POINTS)
    m, level = peaks(found.order, found.threshold, POINTS)
    annotations += [
        note(f"{order:.4g}", order, amplitude, xref="x", yref="y", yanchor="bottom", yshift=6)
        for order, amplitude in found.lines[:3]
    ]
    hover = "%{x:.4g} cycles/rev: %{y:.3g} " + unit
    data = [
        line("residual per order", size, ERROR, x=packed(n), hovertemplate=hover, showlegend=False),
        line("level of noise", level, NOISE, x=packed(m), dash="dash", hoverinfo="skip"),
    ]
    if found.lines:
        x, y = np.array(found.lines).T
        data.append({
            "type": "scatter", "mode": "markers", "name": "lines", "x": list(map(float, x)),
            "y": list(map(float, y)), "hovertemplate": hover,
            "marker": {"color": ALERT, "size": 9, "symbol": "diamond-open"},
        })  # fmt: skip
    return data
