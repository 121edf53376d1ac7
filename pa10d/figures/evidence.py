"""What speaks for one effect: the residual without it, its own torque, the residual with it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.figures.decimate import thinned
from pa10d.figures.errors import binned
from pa10d.figures.plotly import (
    ALERT,
    ERROR,
    MEASURED,
    MODEL,
    NOISE,
    Figure,
    Trace,
    axis,
    band,
    dots,
    layout,
    line,
    log_axis,
    mark,
    note,
    packed,
)

Array = NDArray[np.float64]

POINTS = 1500
EFFECT_BINS = 90  # narrow enough for a step at a reversal


def evidence(
    x: Array,
    label: str,
    before: Array,
    after: Array,
    effect: Array,
    *,
    floor: float | None = None,
    unit: str = "N·m",
) -> Figure:
    """x, before, after, effect: (K,) of the same held-out samples: the quantity that shows the
    effect best (``label``: with unit), the residual without and with it, the torque it adds.
    Left: residual without it, with the effect's torque over it; right: with it. floor: N·m."""
    chosen = thinned(len(x), POINTS)
    limit = 1.05 * float(np.max(np.abs(before))) if len(before) else 1.0
    right = {"xaxis": "x2", "yaxis": "y2", "showlegend": False}
    data = [
        *_cloud(x, before, chosen, {}),
        *_effect_line(x, effect),
        *_cloud(x, after, chosen, right),
    ]
    shapes = []
    if floor is not None:
        shapes = [
            band(pair, (None, None), (-2 * floor, 2 * floor), NOISE, 0.2)
            for pair in (("x", "y"), ("x2", "y2"))
        ]
    figure = layout(
        330,
        shapes=shapes,
        annotations=[
            note(f"without it: RMS {_rms(before):.3g} {unit}", 0.0, 1.0, yanchor="bottom"),
            note(f"with it: RMS {_rms(after):.3g} {unit}", 0.54, 1.0, yanchor="bottom",
                 xanchor="left"),
        ],
        xaxis=axis(label, domain=[0, 0.46]),
        yaxis=axis(f"held-out residual, {unit}", range=[-limit, limit]),
        xaxis2=axis(label, domain=[0.54, 1.0], anchor="y2", matches="x"),
        yaxis2=axis("", anchor="x2", matches="y", range=[-limit, limit]),
    )  # fmt: skip
    figure["margin"] |= {"t": 58}
    figure["legend"] |= {"y": 1.09}
    return {"data": data, "layout": figure}


def before_after(
    joints: Sequence[str],
    before: Array,
    after: Array,
    floor: Array | None = None,
    labels: tuple[str, str] = ("without it", "with it"),
) -> Figure:
    """Held-out RMS per joint (n,) without and with an effect, beside the noise floor, N·m."""
    names = [f"{j + 1} {name}" for j, name in enumerate(joints)]
    bars = [(labels[0], before, MEASURED), (labels[1], after, ERROR)]
    if floor is not None:
        bars.append(("noise floor", floor, NOISE))
    hover = "%{x}: %{y:.4g} N·m"
    data: list[Trace] = [
        {
            "type": "bar", "name": name, "x": names,
            "y": [float(v) if np.isfinite(v) else None for v in values],
            "marker": {"color": color}, "hovertemplate": hover,
        }
        for name, values, color in bars
    ]  # fmt: skip
    figure = layout(
        260,
        barmode="group",
        xaxis=axis("joint", type="category"),
        yaxis=log_axis("RMS, N·m", np.concatenate([values for _, values, _ in bars])),
    )
    return {"data": data, "layout": figure}


def ranking(labels: Sequence[str], gains: Sequence[float], level: float, title: str) -> Figure:
    """Candidates, best first, by what they explain; ``level``: what counts as significant."""
    found = [gain >= level for gain in gains]
    return {
        "data": [
            {
                "type": "bar", "orientation": "h", "y": list(labels)[::-1],
                "x": [float(gain) for gain in gains][::-1],
                "marker": {"color": [ERROR if f else MEASURED for f in found][::-1]},
                "hovertemplate": "%{y}: %{x:.3g}",
            }
        ],
        "layout": layout(
            80 + 26 * len(labels),
            xaxis=axis(title),
            yaxis=axis("", type="category"),
            shapes=[mark(("x", "y"), x=level, color=ALERT)],
            showlegend=False,
        ),
    }  # fmt: skip


def _cloud(x: Array, y: Array, chosen: NDArray[np.int64], refs: dict) -> list[Trace]:
    middle, rows = binned(x, y)
    return [
        dots("residual", x[chosen], y[chosen], ERROR, **refs),
        line("its mean", rows[:, 1], ERROR, x=packed(middle), width=2.2, **refs),
    ]


def _effect_line(x: Array, effect: Array) -> list[Trace]:
    """The effect's torque where it is a curve against x, its samples where it is not."""
    middle, rows = binned(x, effect, EFFECT_BINS)
    spread = float(np.median(rows[:, 2] - rows[:, 0])) if len(rows) else 0.0
    if spread < 0.25 * float(np.std(effect)):
        return [line("the effect", rows[:, 1], MODEL, x=packed(middle), width=3)]
    chosen = thinned(len(x), POINTS)
    return [dots("the effect", x[chosen], effect[chosen], MODEL)]


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
