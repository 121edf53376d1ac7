"""Autocorrelation of what is left within the band of the fit."""

from __future__ import annotations

import numpy as np

from pa10d.compare.whiteness import Whiteness
from pa10d.figures.plotly import ERROR, NOISE, Figure, axis, band, layout, line, packed


def memory(white: Whiteness) -> Figure:
    """White noise stays within the band but for one lag in twenty."""
    limit = 1.96 / np.sqrt(max(white.samples, 1))
    return {
        "data": [
            line("autocorrelation", white.rho[1:], ERROR, x=packed(white.lag[1:]),
                 mode="lines+markers", marker={"size": 5}, hovertemplate="%{x:.3g} s: %{y:.3f}")
        ],
        "layout": layout(
            230,
            xaxis=axis("lag, s", rangemode="tozero"),
            yaxis=axis("autocorrelation"),
            shapes=[band(("x", "y"), (None, None), (-limit, limit), NOISE, 0.25)],
            showlegend=False,
        ),
    }  # fmt: skip
