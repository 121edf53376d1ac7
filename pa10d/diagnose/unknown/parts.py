"""Parts of the samples that may have something for themselves: runs, what lies before or after a
moment of them, what lies beyond a place, what comes on slowly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.regression.side import Side

Array = NDArray[np.float64]


@dataclass(frozen=True)
class InPart:
    """Of these runs (empty: of all) what lies before or after so many seconds, or the whole."""

    runs: tuple[str, ...]
    at: float | None = None
    before: bool = False

    def rows(self, side: Side, joint: int, seconds: Array) -> Array:
        """(m_j,) 1 where a joint's row is in it; seconds: since its run began."""
        there = rows_of(side, joint, self.runs or [run.name for run in side.runs])
        return there if self.at is None else there * ((seconds < self.at) == self.before)


@dataclass(frozen=True)
class InPlace:
    """Of these runs what has this joint (0-based) beyond where it is so many seconds into each, or
    short of it; or, by_speed, what has it turn one way."""

    runs: tuple[str, ...]
    of: int
    seconds: float
    beyond: bool
    by_speed: bool
    at: None = None

    def rows(self, side: Side, joint: int, seconds: Array) -> Array:
        """(m_j,) 1 where a joint's row is in it."""
        rows = []
        for run, context in zip(side.runs, side.contexts, strict=True):
            path = (context.dq if self.by_speed else context.q)[:: run.lowpass.factor, self.of]
            t = context.t[:: run.lowpass.factor] - context.t[0]
            edge = 0.0 if self.by_speed else path[np.argmin(np.abs(t - self.seconds))]
            rows.append(np.column_stack([(path > edge) == self.beyond]))
        return rows_of(side, joint, self.runs) * side.gathered(rows, joint)[:, 0]


@dataclass(frozen=True)
class ByAndBy:
    """Of these runs all, ever more of it: as a joint warms that takes so many seconds for that."""

    runs: tuple[str, ...]
    takes: float
    at: None = None

    def rows(self, side: Side, joint: int, seconds: Array) -> Array:
        """(m_j,) from 0 as its run begins towards 1."""
        return rows_of(side, joint, self.runs) * -np.expm1(-seconds / self.takes)


def rows_of(side: Side, joint: int, runs: Sequence[str]) -> Array:
    """(m_j,) 1 where a joint's row is of these runs."""
    counts = [int(keep[:, joint].sum()) for keep in side.keep]
    return np.repeat([float(run.name in runs) for run in side.runs], counts)


def seconds_of(side: Side, joint: int) -> Array:
    """(m_j,) s since its run began."""
    rows = []
    for run, context in zip(side.runs, side.contexts, strict=True):
        t = context.t[:: run.lowpass.factor] - context.t[0]
        rows.append(np.column_stack([t]))
    return np.asarray(side.gathered(rows, joint)[:, 0])
