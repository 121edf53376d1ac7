"""Each joint's equation without moments of which nobody knows a side, before anything is filtered.

While a joint stands, if only to turn round, its friction is anything between both breakaways, and
no column can say which. A low-pass carries that into the motion before and after. But an equation
that is multiplied by 0 there, on both sides, holds all the same, and low-passed it holds
everywhere: what nobody knows is gone, and what a joint does right after a reversal still counts.

So is a torque that stands at the limit of its channel: what it was is known as little.

The factor falls and rises smoothly. Noise above the cut-off (a differentiated angle has most of it
there) times a step would come down into the band.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import scipy.ndimage
from numpy.typing import NDArray

from pa10d.measurement.signals import Lowpass, through_channel
from pa10d.measurement.spans import spans
from pa10d.measurement.standstill import near, stops

Array = NDArray[np.float64]

RAMP = 0.25  # periods of the cut-off over which the factor rises
SETTLED = 4.0  # delays of a torque channel after which it has forgotten what stood (2 % are left)
FEWEST_MOVING = 8  # filtered samples clear of rests: of fewer nothing can be said


def going(dq: Array, lowpass: Lowpass, fast: Array | None = None, but: Iterable[int] = ()) -> Array:
    """(N, n) 0 where joint i stands or turns round, 1 clear of that.

    dq: (N, n) rad/s; fast: (n,) rad/s, what counts as fast for each joint (default: from dq);
    but: joints (0-based) that are seen throughout.
    """
    samples, reach, seen = len(dq), _remembered(lowpass), set(but)
    stood = np.zeros(dq.shape, dtype=bool)
    for j, found in enumerate(stops(dq, lowpass.rate, fast)):
        if j not in seen:
            stood[:, j] = near(found, samples, reach)
    return _away_from(stood, lowpass)


def below_limits(clipped: NDArray[np.bool_], lowpass: Lowpass, shift: float = 0.0) -> Array | None:
    """(N, n) 0 where joint i's torque stands at a limit, 1 clear of that; None where none does.

    clipped: (N, n); shift: s by which the torque was late.
    """
    if not clipped.any():
        return None
    reach = _remembered(lowpass) + int(np.ceil(abs(shift) * lowpass.rate))
    wide = [near(spans(clipped[:, j]), len(clipped), reach) for j in range(clipped.shape[1])]
    return _away_from(np.stack(wide, axis=1), lowpass)


def rung_by(factor: Array, lowpass: Lowpass) -> NDArray[np.bool_]:
    """(M, n) near where such a factor (N, n) is not 1, as far as the plain low-pass rings."""
    reach = lowpass.settle * lowpass.factor
    wide = [near(spans(one < 1.0), len(one), reach) for one in factor.T]
    return np.stack(wide, axis=1)[:: lowpass.factor]


def _remembered(lowpass: Lowpass) -> int:
    """Samples for which a torque channel has not forgotten yet."""
    channel = lowpass.channel
    return 0 if channel is None else int(np.ceil(SETTLED * channel.delay * lowpass.rate))


def _away_from(out: NDArray[np.bool_], lowpass: Lowpass) -> Array:
    """(N, n) 0 where nothing counts (N, n), and how it rises beside that."""
    ramp = max(RAMP * lowpass.rate / lowpass.cutoff, 1.0)
    factor = np.ones(out.shape)
    for j in np.flatnonzero(out.any(axis=0)):
        away = scipy.ndimage.distance_transform_edt(~out[:, j])
        factor[:, j] = np.sin(0.5 * np.pi * np.minimum(away / ramp, 1.0)) ** 2
    return factor


def filtered(columns: Array, lowpass: Lowpass, going: Array, left: Array) -> Array:
    """(M, …) columns (N, …) behind the low-pass, multiplied by the factor of their equations before
    (N, …) and divided by what that leaves (M, …), by the first axes of the columns."""
    if lowpass.channel is not None:
        flat = through_channel(columns.reshape(len(columns), -1), lowpass.channel, lowpass.rate)
        columns, lowpass = flat.reshape(columns.shape), replace(lowpass, channel=None)
    more = (1,) * (columns.ndim - going.ndim)
    return lowpass(columns * going.reshape(going.shape + more)) / left.reshape(left.shape + more)


def filtered_rows(rows: Array, lowpass: Lowpass, going: Array, left: Array) -> Array:
    """(M, k) the same of columns that lie in rows (k, N), as do their factors (k, N)."""
    rate, channel = lowpass.rate, lowpass.channel
    seen = rows if channel is None else through_channel(rows.T, channel, rate).T
    plain = replace(lowpass, channel=None)
    return plain.of_rows(seen * going, np.arange(len(rows))) / left


def counted(share: Array, lowpass: Lowpass, least: float) -> NDArray[np.bool_]:
    """(M, n) filtered samples of which at least such a part stems from motion."""
    return np.asarray(lowpass.of_torque(share) > least)
