"""The residual against what it may depend on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.compare.places import Place
from pa10d.compare.quantities import Quantity, Values, quantities
from pa10d.compare.regions import Region
from pa10d.figures.decimate import thinned
from pa10d.figures.plotly import (
    ALERT,
    ERROR,
    MODEL,
    NOISE,
    Figure,
    Trace,
    axis,
    band,
    dots,
    layout,
    line,
    packed,
)
from pa10d.judgement.residuals import RunResidual
from pa10d.judgement.scores import moving

Array = NDArray[np.float64]

POINTS = 1500  # samples in a cloud
BINS = 30
WARMS = 0.5  # K: a joint that warmed less tells nothing of warmth
PANELS = ("q", "dq", "ddq", "load", "time", "reversal_travel", "temperature")
GUTTER, UNDER = 0.08, 62  # between columns, share of the width; under a panel, pixels
PANEL = 190  # pixels


def error_maps(
    runs: Sequence[RunResidual],
    joint: int,
    places: Sequence[Place] = (),
    floor: float | None = None,
    kinds: Sequence[str] = PANELS,
) -> Figure:
    """One joint (0-based) over all runs: a panel per kind of quantity of its own motion, and per
    quantity of a neighbour that was found to matter, with the mean and the middle half of the
    residual per bin; found regions are shaded. ``layout.meta.panels``: quantity -> its axis."""
    used = moving(runs, joint)
    robot = used[0].seen.robot
    warm = any(run.seen.temperature is not None for run in used)
    mine = [place.what for place in places if place.joint == joint]
    named = {what.quantity for what in mine}
    regions = [what for what in mine if isinstance(what, Region)]
    looked_at = quantities(robot, joint, warm)
    wanted = sorted(
        (q for q in looked_at if (q.own and q.kind in kinds) or (not q.own and q in named)),
        key=lambda q: kinds.index(q.kind) if q.own else len(kinds),
    )
    values = [Values(run) for run in used]
    error = np.concatenate([run.error[run.counts[:, joint], joint] for run in used])
    panels = []
    for quantity in wanted:
        parts = [of(quantity)[run.counts[:, joint]] for of, run in zip(values, used, strict=True)]
        seen = np.concatenate(parts)
        if quantity.kind != "temperature" or np.ptp(seen) >= WARMS:
            panels.append((quantity, seen, regions))
    unit = robot.torque_unit(joint)
    return _grid(panels, error, floor, unit)


def binned(x: Array, y: Array, bins: int = BINS) -> tuple[Array, Array]:
    """(B,) median position and (B, 3) lower quartile, mean, upper quartile of y, in bins of
    equally many samples; a bin of fewer than eight samples says nothing."""
    good = np.isfinite(x)
    x, y = x[good], y[good]
    bins = min(bins, len(x) // 8)
    if bins < 2:
        return np.empty(0), np.empty((0, 3))
    order = np.argsort(x, kind="stable")
    parts = np.array_split(order, bins)
    middle = np.array([np.median(x[part]) for part in parts])
    rows = [(*np.quantile(y[p], [0.25, 0.75]), y[p].mean()) for p in parts]
    low, high, mean = np.array(rows).T
    return middle, np.column_stack([low, mean, high])


def _grid(
    panels: list[tuple[Quantity, Array, list[Region]]], error: Array, floor: float | None, unit: str
) -> Figure:
    columns, rows = 2, -(-len(panels) // 2)
    data: list[Trace] = []
    shapes: list[dict] = []
    height = rows * (PANEL + UNDER)
    found_at: dict[str, str] = {}
    figure = layout(
        height + 40, shapes=shapes, margin={"l": 62, "r": 18, "t": 40, "b": 0},
        meta={"panels": found_at},
    )  # fmt: skip
    limit = 1.05 * float(np.max(np.abs(error))) if len(error) else 1.0
    chosen = thinned(len(error), POINTS)
    width = (1 - GUTTER) / columns
    for k, (quantity, x, regions) in enumerate(panels):
        suffix = "" if k == 0 else str(k + 1)
        found_at[quantity.name] = f"xaxis{suffix}"
        left, top = (k % columns) * (width + GUTTER), 1 - (k // columns) / rows
        figure[f"xaxis{suffix}"] = axis(
            quantity.label, domain=[left, left + width], anchor=f"y{suffix}"
        )
        figure[f"yaxis{suffix}"] = axis(
            f"residual, {unit}" if k % columns == 0 else "",
            domain=[max(0.0, top - PANEL / height), top], anchor=f"x{suffix}",
            range=[-limit, limit], matches=None if k == 0 else "y",
        )  # fmt: skip
        pair = (f"x{suffix}", f"y{suffix}")
        refs = {"xaxis": pair[0], "yaxis": pair[1], "showlegend": k == 0}
        data += _panel(x, error, chosen, refs)
        if floor is not None:
            shapes.append(band(pair, (None, None), (-2 * floor, 2 * floor), NOISE, 0.18))
        shapes += [
            band(pair, (region.low, region.high), (None, None), ALERT, 0.13)
            for region in regions
            if _same(region.quantity, quantity)
        ] + [
            band(pair, side, (None, None), ALERT, 0.13)
            for region in regions
            if region.quantity.kind == "|dq|" and region.quantity.own and quantity.kind == "dq"
            for side in ((region.low, region.high), (-region.high, -region.low))
        ]
    return {"data": data, "layout": figure}


def _panel(x: Array, error: Array, chosen: NDArray[np.int64], refs: dict) -> list[Trace]:
    middle, rows = binned(x, error)
    at = {"x": packed(middle)} | refs
    unseen = {"width": 0, "hoverinfo": "skip"}
    half = {"fill": "tonexty", "fillcolor": "rgba(232,132,44,0.25)", "legendgroup": "b"}
    return [
        dots("samples", x[chosen], error[chosen], ERROR, legendgroup="a", **refs),
        line("lower quartile", rows[:, 0], MODEL, **unseen, **at | {"showlegend": False}),
        line("middle half", rows[:, 2], MODEL, meta="upper quartile", **unseen, **half, **at),
        line("mean", rows[:, 1], MODEL, width=2.2, legendgroup="c",
             hovertemplate="%{x:.3g}: %{y:.3g}", **at),
    ]  # fmt: skip


def _same(one: Quantity, other: Quantity) -> bool:
    return (one.kind, one.joint) == (other.kind, other.joint)
