"""All joints at a glance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.compare import RunScores
from pa10d.figures.plotly import ERROR, NOISE, Figure, axis, layout, log_axis, mark


def overview(judged: RunScores, joints: Sequence[str], units: Sequence[str]) -> Figure:
    """How many times the noise floor each joint's error is; 1 cannot be bettered. Where the noise
    of no joint is known, how many percent of the range of its torque."""
    by_noise = judged.by_noise
    shown = judged.standing if by_noise else 100 * judged.standing
    names = [f"{j + 1} {name}" for j, name in enumerate(joints)]
    hover = [
        f"RMS {r:.4g} {u}<br>noise floor {f'{f:.4g} {u}' if np.isfinite(f) else 'not known'}"
        for r, f, u in zip(judged.scores.rms, judged.noise_floor, units, strict=True)
    ]
    value = "%{y:.2f} × noise" if by_noise else "%{y:.2f} % of the torque's range"
    return {
        "data": [
            {
                "type": "bar", "x": names, "customdata": hover,
                "y": [float(v) if np.isfinite(v) else None for v in shown],
                "hovertemplate": f"joint %{{x}}: {value}<br>%{{customdata}}<extra></extra>",
                "text": [f"{v:.1f}" if np.isfinite(v) else "?" for v in shown],
                "textposition": "outside",
                "cliponaxis": False, "marker": {"color": ERROR},
            }
        ],
        "layout": layout(
            260,
            bargap=0.45,
            xaxis=axis("joint", type="category"),
            yaxis=(
                log_axis("RMS ÷ noise floor", [1.0, *shown])
                if by_noise
                else axis("RMS, % of the range", rangemode="tozero")
            ),
            shapes=[mark(("x", "y"), y=1.0, color=NOISE)] if by_noise else [],
            showlegend=False,
        ),
    }  # fmt: skip
