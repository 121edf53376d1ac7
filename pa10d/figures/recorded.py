"""A recording as it is: positions and torques of all joints over time."""

from __future__ import annotations

from pa10d.figures.decimate import extremes
from pa10d.figures.plotly import JOINTS, Figure, Trace, axis, layout, line
from pa10d.figures.time import Span, samples_of
from pa10d.measurement.recording import Recording

POINTS = 1600  # per joint and signal


def recorded(recording: Recording, names: tuple[str, ...], span: Span | None = None) -> Figure:
    """Above q, below the measured torque; span: s, only that part, in more detail."""
    dt = 1.0 / recording.rate
    part = samples_of(span, dt, len(recording.q))
    data: list[Trace] = []
    for values, ref, unit in ((recording.q, "y", "rad"), (recording.tau, "y2", "N·m")):
        drawn = [extremes(values[part, j], POINTS) for j in range(values.shape[1])]
        data += [
            line(
                f"{j + 1} {names[j]}", signal, JOINTS[j % len(JOINTS)], yaxis=ref,
                x0=float(recording.t[0]) + part.start * dt, dx=dt * step, legendgroup=str(j),
                showlegend=ref == "y", hovertemplate="%{y:.4g} " + unit,
            )
            for j, (signal, step) in enumerate(drawn)
        ]  # fmt: skip
    return {
        "data": data,
        "layout": layout(
            400,
            hovermode="x",
            xaxis=axis("time, s", anchor="y2", **({"range": list(span)} if span else {})),
            yaxis=axis("position, rad", domain=[0.54, 1.0]),
            yaxis2=axis("torque, N·m", domain=[0.0, 0.46]),
        ),
    }
