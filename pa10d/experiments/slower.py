"""A motion that a joint left against all prediction is tried again, slower."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pa10d.control.faults import Fault
from pa10d.control.joint_figures import JointFigures

SLOWEST = 4.0  # times as long as asked for: what does not go by then is no matter of speed
MORE = 2.0  # times the room to a position limit, each time that it was not enough
ENDS = ("following_error", "velocity_limit", "position_limit")  # of what its speed may lead to


@dataclass(frozen=True)
class Slower:
    """A motion is run at 1/pace of its speed at most, and ``why``; room: times as much of it as
    predicted that each joint keeps to its position limits, (n,) or empty for once; small: as small
    a share of the whole, about where it begins."""

    pace: float = 1.0
    why: str = ""
    room: Sequence[float] = ()
    small: float = 1.0


AS_ASKED = Slower()


def slower_after(
    fault: Fault, figures: JointFigures, pace: float, before: Slower = AS_ASKED
) -> Slower | None:
    """How a motion is tried again that ended so at 1/pace of its speed: at half of that, and with
    more room where a joint came to the end of its range. before: how it was tried this time. None
    where it was slow already, and where a joint may have met something: the prediction of an arm
    without springs is good, so one that falls behind on a way that it had not gone before is held
    by something. One that was too fast, or went too far, is not."""
    if fault.axis is None or fault.kind not in ENDS:
        return None
    sprung = bool(np.isfinite(figures.stiffness).any())
    if fault.kind == "following_error" and not (fault.was_there or sprung):
        return None
    why = f"joint {fault.joint} {fault.cause}, against the prediction"
    room = np.array(before.room) if len(before.room) else np.ones(len(figures.stiffness))
    if fault.kind == "position_limit":
        room[fault.axis] *= MORE
    if pace >= SLOWEST:
        return None
    return Slower(min(2.0 * pace, SLOWEST), why, tuple(room.tolist()), before.small)
