"""The few pieces of Plotly JSON that the figures are made of."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pa10d.common.jsonable import JsonObject

Figure = JsonObject
Trace = JsonObject

# readable on white and on black, and told apart by people who see red and green alike
MEASURED, MODEL, ERROR, NOISE, ALERT = "#8a97a6", "#e8842c", "#3d8fd6", "#2fa58a", "#d8475c"
MANY_DECADES = 300.0  # ratio of values beyond which an axis has room for powers of ten only
LEAST_SPAN = 3.0  # ratio that a logarithmic axis shows at least: half a decade
JOINTS = ("#3d8fd6", "#e8842c", "#2fa58a", "#b8479c", "#9a6210", "#7747ff", "#8a97a6", "#d8475c")


def packed(values: ArrayLike, precise: bool = False) -> dict[str, str]:
    """Numbers as Plotly reads them from base64: a fifth of their size as text.

    precise: eight bytes each instead of four, for long time axes; nan leaves a gap.
    """
    kind = "f8" if precise else "f4"
    data = np.ascontiguousarray(values, dtype=f"<{kind}")
    return {"dtype": kind, "bdata": base64.b64encode(data.tobytes()).decode()}


def line(name: str, y: ArrayLike, color: str, **more: Any) -> Trace:
    """A line; ``x`` or ``x0`` and ``dx`` in ``more``."""
    style = {"color": color, "width": more.pop("width", 1.4)}
    if "dash" in more:
        style["dash"] = more.pop("dash")
    if "shape" in more:
        style["shape"] = more.pop("shape")
    return {"type": "scatter", "mode": "lines", "name": name, "y": packed(y), "line": style} | more


def dots(name: str, x: ArrayLike, y: ArrayLike, color: str, **more: Any) -> Trace:
    """A cloud of samples."""
    marker = {"color": color, "size": 3, "opacity": 0.35}
    return {
        "type": "scatter", "mode": "markers", "name": name, "x": packed(x), "y": packed(y),
        "marker": marker, "hoverinfo": "skip",
    } | more  # fmt: skip


def axis(title: str = "", **more: Any) -> JsonObject:
    """An axis; everything coloured is left to the theme."""
    out: JsonObject = {"automargin": True, "zeroline": False}
    if title:
        out["title"] = {"text": title, "standoff": 8}
    return out | more


def log_axis(title: str, shown: ArrayLike, **more: Any) -> JsonObject:
    """Ticks at 1, 2 and 5 of every decade, written out: Plotly would call 0.5 just "5". At 1 alone
    where the values ``shown`` reach over so many decades that more would overlap. Values that are
    all but the same look so: the axis reaches over a factor of LEAST_SPAN at least."""
    values = np.asarray(shown, dtype=float)
    values = values[np.isfinite(values) & (values > 0)]
    wide = len(values) > 0 and values.max() > MANY_DECADES * values.min()
    digits = (1,) if wide else (1, 2, 5)
    ticks = [digit * 10.0**power for power in range(-9, 10) for digit in digits]
    if len(values) > 0 and values.max() < LEAST_SPAN * values.min():
        middle = 0.5 * np.log10(values.min() * values.max())
        half = 0.5 * np.log10(LEAST_SPAN)
        more = {"range": [float(middle - half), float(middle + half)]} | more
    return axis(title, type="log", tickvals=ticks, ticktext=[f"{t:g}" for t in ticks], **more)


def layout(height: int, **more: Any) -> JsonObject:
    """What all figures share."""
    return {
        "height": height,
        "margin": {"l": 62, "r": 18, "t": 34, "b": 46},
        "legend": {"orientation": "h", "x": 0, "y": 1, "yanchor": "bottom", "xanchor": "left"},
        "hoverlabel": {"namelength": -1},
    } | more


def band(axis_pair: tuple[str, str], x: Sequence[float | None], y: Sequence[float | None],
         color: str, opacity: float = 0.14) -> JsonObject:  # fmt: skip
    """A shaded rectangle; None: the whole length of that axis."""
    (x0, x1), (y0, y1) = x, y
    return {
        "type": "rect", "layer": "below", "line": {"width": 0}, "fillcolor": color,
        "opacity": opacity,
        "xref": axis_pair[0] + (" domain" if x0 is None else ""),
        "yref": axis_pair[1] + (" domain" if y0 is None else ""),
        "x0": 0 if x0 is None else x0, "x1": 1 if x1 is None else x1,
        "y0": 0 if y0 is None else y0, "y1": 1 if y1 is None else y1,
    }  # fmt: skip


def mark(axis_pair: tuple[str, str], *, x: float | None = None, y: float | None = None,
         color: str, dash: str = "dash") -> JsonObject:  # fmt: skip
    """A straight line across the plot at x or at y."""
    at: JsonObject = {"xref": axis_pair[0], "yref": axis_pair[1]}
    if x is not None:
        at |= {"x0": x, "x1": x, "y0": 0, "y1": 1, "yref": f"{axis_pair[1]} domain"}
    else:
        at |= {"y0": y, "y1": y, "x0": 0, "x1": 1, "xref": f"{axis_pair[0]} domain"}
    return {"type": "line", "line": {"color": color, "width": 1.2, "dash": dash}} | at


def note(text: str, x: float, y: float, **more: Any) -> JsonObject:
    """Text on the figure, by default in shares of its width and height."""
    return {
        "text": text, "x": x, "y": y, "xref": "paper", "yref": "paper", "showarrow": False,
    } | more  # fmt: skip
