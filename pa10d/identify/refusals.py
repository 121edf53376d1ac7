"""What cannot be fitted is refused in words, before any work."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics import Robot
from pa10d.identify.excitation import MotionExtent
from pa10d.measurement.recording import Recording
from pa10d.measurement.standstill import NEVER_MOVES
from pa10d.regression.equation import edge_time

FEWEST_PERIODS = 8.0  # of the cut-off between the two ends
FAST_TIME = 1.0  # s that a joint must be faster than what is asked for


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


def check_speeds(faster_than: Sequence[float], robot: Robot) -> NDArray[np.float64]:
    """(n,) rad/s, one per joint."""
    speeds = np.array(faster_than, dtype=float)
    if speeds.shape != (robot.n,) or not np.all(np.isfinite(speeds) & (speeds >= 0)):
        raise UserError(
            f"faster_than: found {list(faster_than)}, expected {robot.n} speeds in rad/s, one per "
            f"joint of {robot.name}, 0 for all samples"
        )
    return speeds


def check_motion(
    seen: MotionExtent,
    recordings: Sequence[Recording],
    faster_than: NDArray[np.float64] | None = None,
) -> MotionExtent:
    """Refuse data in which no joint moves, or none fast enough, or no torque was measured."""
    if faster_than is not None:
        check_fast(seen, faster_than)
    names = ", ".join(r.name for r in recordings)
    if np.any(seen.range > NEVER_MOVES):
        if not any(np.any(r.tau) for r in recordings):
            raise UserError(f"{names}: torque is zero throughout, expected measured torque")
        if seen.hidden.all():
            raise UserError(
                f"{names}: no joint's torque is shown, each comes back to one value whatever its "
                "joint does, expected measured torque"
            )
    if not np.any(seen.seconds > 0):
        raise UserError(f"{names}: no joint moves, expected motion of the joints to be identified")
    return seen


def check_fast(seen: MotionExtent, faster_than: NDArray[np.float64]) -> None:
    """Refuse a threshold above which a moving joint hardly ever is."""
    for j in np.flatnonzero((seen.seconds < FAST_TIME) & (seen.speed > 0) & (faster_than > 0)):
        raise UserError(
            f"joint {j + 1} is faster than {faster_than[j]:.3g} rad/s for {seen.seconds[j]:.2g} s "
            f"only, expected at least {FAST_TIME:g} s: a faster trajectory (this one reaches "
            f"{seen.speed[j]:.3g} rad/s), or a lower threshold"
        )
