"""Each joint's equation without the moments at which it stands, before anything is filtered.

While a joint stands, if only to turn round, its friction is anything between both breakaways, and
no column can say which. A low-pass carries that into the motion before and after. But an equation
that is multiplied by 0 there, on both sides, holds all the same, and low-passed it holds
everywhere: what nobody knows is gone, and what a joint does right after a reversal still counts.

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
    samples, rate, channel = len(dq), lowpass.rate, lowpass.channel
    reach = 0 if channel is None else int(np.ceil(SETTLED * channel.delay * rate))
    ramp = max(RAMP * rate / lowpass.cutoff, 1.0)
    out, seen = np.ones(dq.shape), set(but)
    for j, found in enumerate(stops(dq, rate, fast)):
        stood = near(found, samples, reach)
        if j not in seen and stood.any():
            away = scipy.ndimage.distance_transform_edt(~stood)
            out[:, j] = np.sin(0.5 * np.pi * np.minimum(away / ramp, 1.0)) ** 2
    return out


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
