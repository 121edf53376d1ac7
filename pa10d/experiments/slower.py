"""A motion that a joint left against all prediction is tried again, slower."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pa10d.control.faults import Fault
from pa10d.control.joint_figures import JointFigures

SLOWEST = 4.0  # times as long as asked for: what does not go by then is no matter of speed
ENDS = ("following_error", "velocity_limit", "position_limit")  # of what its speed may lead to


@dataclass(frozen=True)
class Slower:
    """A motion is run at 1/pace of its speed at most, and ``why``."""

    pace: float = 1.0
    why: str = ""


AS_ASKED = Slower()


def slower_after(fault: Fault, figures: JointFigures, pace: float) -> Slower | None:
    """How a motion is tried again that ended so at 1/pace of its speed: at half of that. None where
    it was slow already, and where a joint may have met something: the prediction of an arm without
    springs is good, so one that falls behind on a way that it had not gone before is held by
    something. One that was too fast, or went too far, is not."""
    if fault.axis is None or fault.kind not in ENDS:
        return None
    sprung = bool(np.isfinite(figures.stiffness).any())
    if fault.kind == "following_error" and not (fault.was_there or sprung):
        return None
    why = f"joint {fault.joint} {fault.cause}, against the prediction"
    return Slower(2.0 * pace, why) if 2.0 * pace <= SLOWEST else None
