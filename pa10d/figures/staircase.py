"""Error of every version of a model: does it go down, and how far is it from the noise?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.figures.plotly import JOINTS, NOISE, Figure, Trace, axis, layout, log_axis, mark
from pa10d.figures.texts import TEXTS, Reading

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stair:
    """One version: its name, what was changed, RMS per joint (n,) N·m on the same runs."""

    name: str
    change: str
    rms: Array


def floor_of_all(floor: Array | None) -> Array | None:
    """(n,) N·m that the errors are drawn as multiples of; None where the data hide that of a joint,
    which could not be drawn so."""
    return floor if floor is not None and np.all(np.isfinite(floor)) else None


def staircase_text(floor: Array | None = None) -> Reading:
    """How to read a staircase: in its units, or in multiples of the noise."""
    whole = floor_of_all(floor) is not None
    return TEXTS["staircase"].told(True) if whole else TEXTS["staircase_in_units"]


def staircase(steps: Sequence[Stair], joints: Sequence[str], floor: Array | None = None) -> Figure:
    """One line per joint from version to version; with a noise floor (n,) N·m of every joint as
    multiples of it, so that all share one scale whose bottom is 1. Where the data hide the floor
    of one, the scale is N·m."""
    floor = floor_of_all(floor)
    names = [step.name for step in steps]
    rms = np.array([step.rms for step in steps])
    shown = rms if floor is None else rms / np.maximum(floor, 1e-300)
    changes = [step.change for step in steps]
    traces: list[Trace] = [
        {
            "type": "scatter", "mode": "lines+markers", "name": f"{j + 1} {name}",
            "x": names, "y": [float(v) if np.isfinite(v) else None for v in shown[:, j]],
            "customdata": [
                [float(value), change] for value, change in zip(rms[:, j], changes, strict=True)
            ],
            "hovertemplate": "%{x}: %{customdata[1]}<br>%{customdata[0]:.4g} N·m"
            + ("" if floor is None else ", %{y:.2f} × noise"),
            "line": {"shape": "hvh", "width": 2, "color": JOINTS[j % len(JOINTS)]},
            "marker": {"size": 7},
        }
        for j, name in enumerate(joints)
    ]  # fmt: skip
    figure = layout(
        330,
        xaxis=axis("", type="category", ticktext=[_tick(step) for step in steps], tickvals=names),
        yaxis=(
            log_axis("RMS, N·m", shown)
            if floor is None
            else log_axis("RMS ÷ noise floor", [1.0, *shown[np.isfinite(shown)]])
        ),
        shapes=[] if floor is None else [mark(("x", "y"), y=1.0, color=NOISE)],
    )
    figure["margin"] |= {"b": 70}
    return {"data": traces, "layout": figure}


def _tick(step: Stair) -> str:
    change, *note = step.change.split(" (", 1)
    return "<br>".join([step.name, f"<i>{change}</i>", *(f"<i>({text}</i>" for text in note)])
