"""Where joints stand still: friction is indeterminate there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.measurement.signals import Lowpass
from pa10d.measurement.spans import spans

Array = NDArray[np.float64]

NEVER_MOVES = 5e-3  # rad or m: a joint that keeps within so little is at rest in all of a run
STILL_SHARE = 0.01  # of the 99 % quantile of speed: slower is standing or creeping
HELD_SHARE = 0.01  # of the farthest travel of its kind: less is a servo that gives way
RESTING = 0.08  # s: a stop that long is a rest, a shorter one a reversal
REACH = 0.8  # periods of the cut-off over which the filter remembers a standstill
NARROWER = ((REACH, 0.5), (0.5, 0.1), (0.0, 0.0))
"""Periods of the cut-off that are cut around a reversal, and the share of the joint's motion that
has to remain; the first that leaves as much is taken. The filter's main lobe ends after half a
period, and what rings beyond it is at most a seventh of its peak (a ninth beyond 0.8)."""


def fast_speed(dq: Array) -> Array:
    """(n,) rad/s: the 99 % quantile of each joint's speed."""
    return np.asarray(np.quantile(np.abs(dq), 0.99, axis=0))


def held(q: Array, kinds: Sequence[str]) -> NDArray[np.bool_]:
    """(n,): True where joint i is held in this run while others travel.

    Its own speed does not tell that: a held joint gives way by a milliradian to what the others do,
    within the travel that friction takes to build up. q: (N, n) rad, m; kinds: (n,) whose travels
    can be compared with each other, such as "rad" and "m".
    """
    travel, of = np.ptp(q, axis=0), np.array(kinds)
    farthest = np.array([travel[of == kind].max() for kind in kinds])
    return np.asarray(travel < HELD_SHARE * farthest)


def standstill(
    dq: Array,
    rate: float,
    lowpass: Lowpass,
    fast: Array | None = None,
    longer_than: float = 0.0,
    wider: float = 1.0,
) -> NDArray[np.bool_]:
    """(M, n): True where joint i stands, or stood so near that the filter still sees it.

    A joint stands while its speed is below STILL_SHARE of its fast speed. Creeping counts, and so
    does the instant of a reversal: a real joint sticks there, for how long nobody measured, and
    friction is anything between ±Fs meanwhile. A joint that turns round so often that this would
    leave little of its motion is cut less far around its reversals (see ``NARROWER``), and around
    its rests as far as any other.

    longer_than: s, shorter stops are left out; wider: factor on how far the cuts reach.
    """
    samples = len(dq)
    shortest = max(1, int(longer_than * rate))
    out = np.zeros((lowpass.kept, dq.shape[1]), dtype=bool)
    for j, found in enumerate(stops(dq, rate, fast)):
        long = found[:, 1] - found[:, 0] >= int(RESTING * rate)
        turns = found[~long & (found[:, 1] - found[:, 0] >= shortest)]
        periods = rate / lowpass.cutoff
        resting = near(found[long], samples, int(REACH * periods))
        left = samples - int(resting.sum())
        for reach, enough in NARROWER:
            cut = resting | near(turns, samples, int(reach * periods))
            if samples - int(cut.sum()) >= enough * left:
                break
        if wider > 1.0:
            cut = near(found[long], samples, int(wider * REACH * periods))
            cut |= near(turns, samples, int(wider * reach * periods))
        out[:, j] = cut[:: lowpass.factor]
    return out


def share_left(
    dq: Array, rate: float, cutoff: float, edge: float, fast: Array | None = None
) -> tuple[Array, Array]:
    """((n,), (n,)): samples of each joint's motion, and how many of them a filter of ``cutoff`` Hz
    leaves to be judged: not within ``edge`` s of the ends, nor near a rest or reversal."""
    samples, periods = len(dq), rate / cutoff
    ends = int(np.ceil(edge * rate))
    inside = np.zeros(samples, dtype=bool)
    inside[ends : max(ends, samples - ends)] = True
    moves, left = np.zeros(dq.shape[1]), np.zeros(dq.shape[1])
    for j, found in enumerate(stops(dq, rate, fast)):
        long = found[:, 1] - found[:, 0] >= int(RESTING * rate)
        cut = near(found, samples, int(REACH * periods))
        moves[j] = samples - int(near(found[long], samples, 0).sum())
        left[j] = int((inside & ~cut).sum())
    return moves, left


def stops(dq: Array, rate: float, fast: Array | None = None) -> list[NDArray[np.int64]]:
    """Per joint (k, 2): samples at which it begins to stand, or turns round, and moves again."""
    limits = np.maximum(STILL_SHARE * (fast_speed(dq) if fast is None else fast), 1e-9)
    out = []
    for j, limit in enumerate(limits):
        slow = np.abs(dq[:, j]) < limit
        slow[1:] |= np.diff(np.sign(dq[:, j])) != 0
        out.append(spans(slow))
    return out


def since_rest(dq: Array, rate: float) -> Array:
    """(N,) s since one joint of speed (N,) last stood longer than a reversal takes: 0 while it
    stands, infinite before it first did."""
    (found,) = stops(dq[:, None], rate)
    rests = found[found[:, 1] - found[:, 0] >= int(RESTING * rate)]
    if not len(rests):
        return np.full(len(dq), np.inf)
    at = np.arange(len(dq))
    last = np.searchsorted(rests[:, 0], at, side="right") - 1
    gone = (at - rests[last, 1]) / rate
    return np.where(last < 0, np.inf, np.maximum(gone, 0.0))


def near(stops: NDArray[np.int64], samples: int, reach: int) -> NDArray[np.bool_]:
    """(samples,) within ``reach`` samples of the stretches ``stops`` (k, 2), begin and end."""
    change = np.zeros(samples + 1, dtype=np.int64)
    np.add.at(change, np.maximum(0, stops[:, 0] - reach), 1)
    np.add.at(change, np.minimum(samples, stops[:, 1] + reach), -1)
    return np.asarray(np.cumsum(change)[:samples] > 0)
