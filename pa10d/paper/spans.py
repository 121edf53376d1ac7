"""A recording cut into what its plan's segments were for."""

from __future__ import annotations

import numpy as np

from pa10d.measurement.recording import Recording
from pa10d.trajectory.plan import Plan


def steady_parts(
    recording: Recording, plan: Plan, begin: float = 0.0, joint: int | None = None
) -> dict[str, Recording]:
    """label -> the part of a segment that an analysis looks at, without run-up and run-out.

    begin: s on the recording's clock at which the plan began. Labels that repeat get a number.
    joint: of the segments about this one alone, 1-based; None: of all.
    """
    found: dict[str, Recording] = {}
    for span in plan.spans:
        first, last = np.searchsorted(recording.t, [begin + span.begin, begin + span.end])
        if last - first < 2 or joint not in (None, span.joint):
            continue
        label, number = span.label, 2
        while label in found:
            label, number = f"{span.label} ({number})", number + 1
        found[label] = recording.part(int(first), int(last), f": {label}")
    return found
