"""What a small step shows of a joint's servo: rise, overshoot, settling, error meanwhile."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

Array = NDArray[np.float64]

RISE = (0.1, 0.9)  # of the step
SETTLED = 0.05  # of the step, to either side of where it ends
STILL = 1e-7  # rad (m) from one sample to the next: the target rests


@dataclass(frozen=True)
class StepFigures:
    """One step; null: the joint did not get there before the next one."""

    size: Annotated[float, Field(description="rad, m")]
    rise: Annotated[float | None, Field(description="s from 10 to 90 %")]
    target_rise: Annotated[float | None, Field(description="s, of the target: limits make no jump")]
    overshoot: Annotated[float, Field(description="Share of the step")]
    settling: Annotated[float | None, Field(description="s until it stays within 5 %")]
    rms: Annotated[float, Field(description="rad, m: tracking error")]
    worst: Annotated[float, Field(description="rad, m: tracking error")]

    def sentence(self, joint: int) -> str:
        """For a person; joint: from 1."""
        rise = "does not get there" if self.rise is None else f"rises in {self.rise:.3g} s"
        settles = (
            "does not settle" if self.settling is None else f"settles in {self.settling:.3g} s"
        )
        return f"joint {joint} {rise}, overshoots by {self.overshoot:.0%}, {settles}"


def steps_of(t: Array, target: Array, response: Array) -> list[StepFigures]:
    """t (N,) s, target and response (N,) rad (m) of one joint → its steps, in order."""
    return [
        _figures(t[first:last] - t[first], target[first:last], response[first:last])
        for first, last in _windows(target)
    ]


def first_move(target: Array) -> int:
    """The sample after which a target (N,) begins to move; 0 where it rests."""
    return next((first for first, _ in _windows(target)), 0)


def _windows(target: Array) -> Iterator[tuple[int, int]]:
    """From each begin of a move to the begin of the next."""
    moving = np.concatenate([[False], np.abs(np.diff(target)) > STILL])
    begins = np.flatnonzero(moving[1:] & ~moving[:-1])
    for first, last in pairwise([*map(int, begins), len(target)]):
        if abs(target[last - 1] - target[first]) > STILL:  # a run may end within a step
            yield first, last


def _figures(t: Array, target: Array, response: Array) -> StepFigures:
    size = float(target[-1] - target[0])
    share = (response - target[0]) / size
    error = target - response
    outside = np.flatnonzero(np.abs(share - 1.0) > SETTLED)
    last = int(outside[-1]) + 1 if len(outside) else 0
    return StepFigures(
        size=size,
        rise=_rise(t, share),
        target_rise=_rise(t, (target - target[0]) / size),
        overshoot=max(float(share.max()) - 1.0, 0.0),
        settling=float(t[last]) if last < len(t) else None,
        rms=float(np.sqrt(np.mean(error**2))),
        worst=float(np.abs(error).max()),
    )


def _rise(t: Array, share: Array) -> float | None:
    times = [_crossing(t, share, level) for level in RISE]
    return None if times[0] is None or times[1] is None else times[1] - times[0]


def _crossing(t: Array, share: Array, level: float) -> float | None:
    """s at which a level is reached first, between samples."""
    above = np.flatnonzero(share >= level)
    if not len(above):
        return None
    k = int(above[0])
    if k == 0:
        return float(t[0])
    part = (level - share[k - 1]) / (share[k] - share[k - 1])
    return float(t[k - 1] + part * (t[k] - t[k - 1]))
