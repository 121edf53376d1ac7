"""All joints at a glance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.figures.plotly import ERROR, NOISE, Figure, axis, layout, mark

Array = NDArray[np.float64]


def overview(joints: Sequence[str], rms: Array, floor: Array, units: Sequence[str]) -> Figure:
    """How many times the noise floor each joint's error is; 1 cannot be bettered."""
    ratio = rms / np.maximum(floor, 1e-300)  # nan where the noise is not known: no bar
    names = [f"{j + 1} {name}" for j, name in enumerate(joints)]
    hover = [
        f"RMS {r:.4g} {u}<br>noise floor {f'{f:.4g} {u}' if np.isfinite(f) else 'not known'}"
        for r, f, u in zip(rms, floor, units, strict=True)
    ]
    return {
        "data": [
            {
                "type": "bar", "x": names, "customdata": hover,
                "y": [float(v) if np.isfinite(v) else None for v in ratio],
                "hovertemplate": "joint %{x}: %{y:.2f} × noise<br>%{customdata}<extra></extra>",
                "text": [f"{v:.1f}" if np.isfinite(v) else "?" for v in ratio],
                "textposition": "outside",
                "cliponaxis": False, "marker": {"color": ERROR},
            }
        ],
        "layout": layout(
            260,
            bargap=0.45,
            xaxis=axis("joint", type="category"),
            yaxis=axis("RMS ÷ noise floor", type="log", dtick=1),
            shapes=[mark(("x", "y"), y=1.0, color=NOISE)],
            showlegend=False,
        ),
    }  # fmt: skip
