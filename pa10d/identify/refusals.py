"""What cannot be fitted is refused in words, before any work."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.dynamics import Robot
from pa10d.equation import edge_time
from pa10d.errors import UserError
from pa10d.identify.excitation import Excitation
from pa10d.recording import Recording

FEWEST_PERIODS = 8.0  # of the cut-off between the two ends


def check(recordings: Sequence[Recording], robot: Robot) -> None:
    """Refuse what cannot be fitted, in words."""
    if not recordings:
        raise UserError("identify: no recording given, expected at least one")
    for recording in recordings:
        if recording.joints != robot.n:
            raise UserError(
                f"{recording.name}: {recording.joints} joints, expected {robot.n} as in "
                f"{robot.name}"
            )
        for what, values in (("q", recording.q), ("tau", recording.tau)):
            bad = np.argwhere(~np.isfinite(values))
            if len(bad):
                raise UserError(
                    f"{recording.name}: {what}{bad[0, 1] + 1} at {recording.t[bad[0, 0]]:g} s is "
                    "not a number, expected finite values"
                )


def check_length(recordings: Sequence[Recording], cutoff: float) -> None:
    """Refuse runs of which nothing is left once the filters have settled."""
    for recording in recordings:
        needed = 2.0 * edge_time(recording.rate, cutoff) + FEWEST_PERIODS / cutoff
        if recording.duration < needed:
            raise UserError(
                f"{recording.name}: {recording.duration:.2g} s are too short for a cut-off of "
                f"{cutoff:g} Hz, expected at least {needed:.2g} s"
            )


def check_motion(seen: Excitation, recordings: Sequence[Recording]) -> Excitation:
    """Refuse data in which no joint moves or no torque was measured."""
    names = ", ".join(r.name for r in recordings)
    if not np.any(seen.seconds > 0):
        raise UserError(f"{names}: no joint moves, expected motion of the joints to be identified")
    if not any(np.any(r.tau) for r in recordings):
        raise UserError(f"{names}: torque is zero throughout, expected measured torque")
    return seen
