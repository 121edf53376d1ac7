"""Which of a message's two stamps its samples are at: the header's, or that of its reception."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.readers.bag_rows import BagRows
from pa10d.store.channels import Array

Stamps = NDArray[np.int64]

LATE = 10.0  # usual steps by which one sender's messages may overtake each other
LATEST = 0.05  # s; the same for fast senders
ANEW = 0.1  # of what was reached, below which stamps have begun anew
LONG = 10.0  # s: no clock that runs is set back so far
WINDOW = 40  # samples
APART = 1e-3  # rad: two levels of an encoder are nearer to each other
TIMES = 5.0  # the next sample is further away than the one after it
FEW = 10  # samples before a pause that are of something else


def clock_of(blocks: Sequence[BagRows]) -> tuple[bool, str]:
    """Whether the times of reception are taken, and why."""
    own = np.concatenate([block.times(received=False) for block in blocks])
    zero = int((own <= 0).sum())
    if zero == len(own):
        return True, ""
    if zero > FEW:  # a few stand before the others, see begin_of, or simulated time begins there
        return True, f"{zero} of {len(own)} headers have no stamp: times of reception are taken"
    for block in blocks:
        said = _of_one(block)
        if said:
            return True, said
    apart = _apart(blocks)
    if apart > LATEST:
        return True, f"clocks of the senders differ by {apart:.3g} s: times of reception are taken"
    return False, ""


def _apart(blocks: Sequence[BagRows]) -> float:
    """s between the senders' clocks, by how late each one's messages came."""
    late = [
        float(np.median(block.times(received=True) - block.times(received=False))) * 1e-9
        for block in blocks
        if len(block.stamps) >= FEW
    ]
    return max(late) - min(late) if late else 0.0


def _of_one(block: BagRows) -> str:
    own, came_at = block.times(received=False), block.times(received=True)
    stamped = own > 0
    own, came_at = own[stamped], came_at[stamped]
    if len(own) < 3:
        return ""
    steps = np.diff(own) * 1e-9
    came = int((np.diff(came_at) > 0).sum())
    if came > 2 * int((steps > 0).sum()):
        return (
            "stamps of the headers stand still, or have whole seconds only: times of reception "
            "are taken"
        )
    if not (steps > 0).any():
        return ""  # all at one moment, which is refused as that
    usual = float(np.median(steps[steps > 0]))
    k = int(steps.argmin())
    if -steps[k] <= max(LATE * usual, LATEST):
        return ""
    reached, left = (float(own[i] - own[0]) * 1e-9 for i in (k, k + 1))
    told = f"stamps of the headers go back by {-steps[k]:.3g} s after {reached:.3f} s"
    if -steps[k] > LONG or left < ANEW * reached:
        raise UserError(f"{told}: they begin anew; expected one recording (cut the bag there)")
    return f"{told} (a clock was set): times of reception are taken"


def refuse_two_courses(t: Array, q: Array) -> None:
    """UserError where neighbours are far apart and every second sample is near: what a clock that
    was set back while recording leaves, or two senders of the same joints. t (N,) s; q (N,)."""
    windows = (len(q) - 2) // WINDOW
    if windows < 1:
        return
    length = windows * WINDOW
    next_, second = (np.abs(q[k : k + length] - q[:length]) for k in (1, 2))
    near = np.median(next_.reshape(windows, WINDOW), axis=1)
    far = np.median(second.reshape(windows, WINDOW), axis=1)
    mixed = np.flatnonzero((near > APART) & (near > TIMES * far))
    if len(mixed):
        begin, end = t[mixed[0] * WINDOW], t[(mixed[-1] + 1) * WINDOW]
        raise UserError(
            f"between {begin:.3f} and {end:.3f} s every second sample is of another course: two "
            "senders of the same joints, or a clock that was set back; expected one recording"
        )


def begin_of(stamps: Stamps) -> int:
    """Index of the first sample: behind a few that are of long ago, such as one that was kept for
    whoever would listen, or that had no stamp before the clock was known."""
    steps = np.diff(stamps[: FEW + 1]) * 1e-9
    if len(stamps) < 3 * FEW:
        return 0
    usual = float(np.median(np.diff(stamps))) * 1e-9
    nothing = stamps[: len(steps)] <= 0
    pauses = np.flatnonzero((steps > np.where(nothing, 0.0, LONG)) & (steps > 100 * usual))
    return int(pauses[-1]) + 1 if len(pauses) else 0
