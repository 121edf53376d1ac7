"""Runs whose torques are late by different times: another logger, another filter, another drive.

One model has one shift. Fitted to such runs it is right for neither, and what it leaves looks like
friction or a spring.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.common.errors import UserError
from pa10d.dynamics import Robot
from pa10d.identify.blocks import Pieces, middle
from pa10d.identify.timing import EARLIEST, FARTHEST, SIGNIFICANT, USUAL, Shift, find_shift
from pa10d.measurement.recording import Recording
from pa10d.regression.layout import Layout


def late_apart(
    recordings: Sequence[Recording], robot: Robot, layout: Layout, cutoff: float
) -> str | None:
    """A warning where two runs differ by more than their doubt, and by more than what a lack of the
    model makes of one motion and not of another (EARLIEST, or a sample)."""
    if len(recordings) < 2:
        return None
    asked = [_shift_of(one, robot, layout, cutoff) for one in recordings]
    known = {r.name: s for r, s in zip(recordings, asked, strict=True) if s is not None}
    if len(known) < 2:
        return None
    early = min(known, key=lambda name: known[name].estimate)
    late = max(known, key=lambda name: known[name].estimate)
    apart = known[late].estimate - known[early].estimate
    doubt = float(np.hypot(known[late].std_error, known[early].std_error))
    least = max(EARLIEST, *(1.0 / r.rate for r in recordings))
    if apart <= max(SIGNIFICANT * doubt, least):
        return None
    return (
        f"torque is {apart * 1e3:.2f} ± {doubt * 1e3:.2f} ms later against position in run {late} "
        f"than in run {early}: one model cannot be right for both; fit it to runs that were "
        "recorded alike"
    )


def _shift_of(recording: Recording, robot: Robot, layout: Layout, cutoff: float) -> Shift | None:
    try:
        found = find_shift(Pieces([middle(recording)], robot, layout, cutoff), layout)
    except UserError:
        return None
    known = found.std_error < USUAL and abs(found.estimate) < FARTHEST
    return found if known else None
