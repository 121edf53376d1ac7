"""Figures of the case study that stand beside the paper's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pa10d.figures.decimate import extremes
from pa10d.figures.plotly import (
    ERROR,
    JOINTS,
    MEASURED,
    MODEL,
    NOISE,
    Figure,
    axis,
    band,
    layout,
    line,
    note,
    packed,
)
from pa10d.paper.results import (
    MODEL as COMPUTED,
)
from pa10d.paper.results import (
    PID,
    WITH_EFFECTS,
    Following,
    Preparation,
    Reconstruction,
)

POINTS = 1500
GAP = 0.16  # between rows of panels
LAWS = {
    PID: ("PID", ERROR),
    COMPUTED: ("computed torque", MODEL),
    WITH_EFFECTS: ("computed torque, low-speed effect added", NOISE),
}


def exciting_motion(found: Preparation, limit: Sequence[float]) -> Figure:
    """One period: position, and velocity over its boundary."""
    step = max(1, len(found.t) // POINTS)
    t = packed(found.t[::step])
    data = []
    for j in range(found.q.shape[1]):
        name, color = f"joint {j + 1}", JOINTS[j]
        data += [
            line(name, found.q[::step, j], color, x=t),
            line(name, found.dq[::step, j] / limit[j], color, x=t, yaxis="y2", showlegend=False),
        ]
    return {
        "data": data,
        "layout": layout(
            430,
            shapes=[band(("x", "y2"), (None, None), (-1.0, 1.0), MEASURED, 0.22)],
            xaxis=axis("time, s", anchor="y2"),
            yaxis=axis("position, rad", domain=[0.54, 1.0]),
            yaxis2=axis("velocity ÷ boundary", domain=[0.0, 0.46]),
        ),
    }  # fmt: skip


def reconstruction(found: Reconstruction, joint: int) -> Figure:
    """Measured torque, and what both models make of the same motion; their errors below."""
    all_ = np.column_stack([found.measured[:, joint], found.set_a[:, joint], found.set_b[:, joint]])
    drawn, step = extremes(all_, POINTS)
    dt = float(found.t[1] - found.t[0]) * step
    grid = {"x0": float(found.t[0]), "dx": dt}
    parts = (("measured", 0, MEASURED), ("set A", 1, NOISE), ("set B", 2, MODEL))
    above = [line(name, drawn[:, k], color, **grid) for name, k, color in parts]
    below = [
        line(name, drawn[:, 0] - drawn[:, k], color, yaxis="y2", showlegend=False, **grid)
        for name, k, color in parts[1:]
    ]
    return {
        "data": [*above, *below],
        "layout": layout(
            400,
            xaxis=axis("time, s", anchor="y2"),
            yaxis=axis("torque, N·m", domain=[0.42, 1.0]),
            yaxis2=axis("measured − model, N·m", domain=[0.0, 0.34]),
        ),
    }


def tracking(runs: Mapping[str, Following]) -> Figure:
    """Tracking errors of all joints, one panel each, joint 1 to 4 as in the paper."""
    data, axes, notes = [], {}, []
    first = next(iter(runs.values()))
    n = first.error.shape[1]
    rows = -(-n // 2)
    height = (1.0 - GAP * (rows - 1)) / rows
    for j in range(n):
        row, column = divmod(j, 2)
        ref = "" if j == 0 else str(j + 1)
        top, right = 1.0 - row * (height + GAP), 0.54 * column
        axes[f"yaxis{ref}"] = axis("mrad", domain=[max(top - height, 0.0), top], anchor=f"x{ref}")
        last = row == rows - 1
        axes[f"xaxis{ref}"] = axis(
            "time, s" if last else "", domain=[right, right + 0.46], anchor=f"y{ref}"
        )
        notes.append(note(f"joint {j + 1}", right, top, yanchor="bottom", xanchor="left"))
        for how, run in runs.items():
            name, color = LAWS[how]
            drawn, step = extremes(1e3 * run.error[:, [j]], POINTS)
            dt = float(run.t[1] - run.t[0]) * step
            data.append(
                line(
                    name, drawn[:, 0], color, x0=0.0, dx=dt, xaxis=f"x{ref}", yaxis=f"y{ref}",
                    showlegend=j == 0, legendgroup=how, width=1.0,
                )
            )  # fmt: skip
    legend = {"orientation": "h", "x": 0, "y": 1.06, "yanchor": "bottom", "xanchor": "left"}
    return {
        "data": data,
        "layout": layout(220 * rows, annotations=notes, **axes) | {"legend": legend},
    }


def tracking_bars(paces: Mapping[str, Mapping[str, Following]]) -> Figure:
    """RMS tracking error per joint and controller; one panel per pace."""
    data, axes, notes = [], {}, []
    for k, (pace, runs) in enumerate(paces.items()):
        ref, left = "" if k == 0 else str(k + 1), 0.54 * k
        axes[f"xaxis{ref}"] = axis("joint", domain=[left, left + 0.46], anchor=f"y{ref}", dtick=1)
        axes[f"yaxis{ref}"] = axis("RMS, mrad", anchor=f"x{ref}", rangemode="tozero")
        notes.append(
            note(f"period {pace.removesuffix('s')} s", left, 1.0, yanchor="bottom", xanchor="left")
        )
        for how, run in runs.items():
            name, color = LAWS[how]
            data.append(
                {
                    "type": "bar", "name": name, "x": list(range(1, len(run.rms) + 1)),
                    "y": packed(1e3 * run.rms), "marker": {"color": color}, "legendgroup": how,
                    "showlegend": k == 0, "xaxis": f"x{ref}", "yaxis": f"y{ref}",
                }
            )  # fmt: skip
    legend = {"orientation": "h", "x": 0, "y": 1.08, "yanchor": "bottom", "xanchor": "left"}
    return {
        "data": data,
        "layout": layout(330, barmode="group", annotations=notes, **axes) | {"legend": legend},
    }
