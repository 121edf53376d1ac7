"""How wide a band must be for the filter's own memory to leave enough of the motion.

Around every end of a run, every rest and every reversal a filter blurs what nobody can know into
what one wants to judge; the narrower its band, the farther. Short runs and fast joints ask for a
wider one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.measurement.motion import motion, velocity_source
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass
from pa10d.measurement.standstill import share_left
from pa10d.regression.equation import edge_time, motion_band

ENOUGH = 0.5  # of the motion
STEP = 1.15  # by which a band is widened at a time
LONGEST = 40_000  # samples of a run that are looked at


def wide_enough(recordings: Sequence[Recording], lowest: float, highest: float) -> float:
    """Hz between ``lowest`` and ``highest``: the narrowest band in which half of the motion (of
    the joints' median) is left; ``lowest`` where that is above ``highest``."""
    if highest <= lowest:
        return lowest
    looks = []
    for recording in recordings:
        spare = max(0, len(recording.t) - LONGEST) // 2
        part = recording.part(spare, len(recording.t) - spare, "")
        light = Lowpass(len(part.t), part.rate, motion_band(part.rate, highest))
        looks.append((motion(part, light, velocity_source(part, lowest))[1], part.rate))
    cutoff = lowest
    while cutoff < highest:
        found = [share_left(dq, r, cutoff, edge_time(r, cutoff)) for dq, r in looks]
        moves, left = (np.sum([f[i] for f in found], axis=0) for i in (0, 1))
        moving = moves > 0
        if not moving.any() or np.median(left[moving] / moves[moving]) >= ENOUGH:
            return cutoff
        cutoff = min(highest, float(f"{STEP * cutoff:.2g}"))
    return highest
