"""Each joint's equation without the moments at which it stands, before anything is filtered.

While a joint stands, if only to turn round, its friction is anything between both breakaways, and
no column can say which. A low-pass carries that into the motion before and after. But an equation
that is multiplied by 0 there, on both sides, holds all the same, and low-passed it holds
everywhere: what nobody knows is gone, and what a joint does right after a reversal still counts.

The factor falls and rises smoothly. Noise above the cut-off (a differentiated angle has most of it
there) times a step would come down into the band.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.ndimage
from numpy.typing import NDArray

from pa10d.measurement.signals import Lowpass, through_channel
from pa10d.measurement.standstill import near, stops

Array = NDArray[np.float64]

RAMP = 0.25  # periods of the cut-off over which the factor rises
SETTLED = 4.0  # delays of a torque channel after which it has forgotten what stood (2 % are left)
FEWEST_MOVING = 20  # filtered samples: a joint with fewer hardly moves


def going(dq: Array, lowpass: Lowpass, fast: Array | None = None, but: Sequence[int] = ()) -> Array:
    """(N, n) 0 where joint i stands or turns round, 1 clear of that.

    dq: (N, n) rad/s; fast: (n,) rad/s, what counts as fast for each joint (default: from dq);
    but: joints (0-based) that are seen throughout.
    """
    samples, rate, channel = len(dq), lowpass.rate, lowpass.channel
    reach = 0 if channel is None else int(np.ceil(SETTLED * channel.delay * rate))
    ramp = max(RAMP * rate / lowpass.cutoff, 1.0)
    out = np.ones(dq.shape)
    for j, found in enumerate(stops(dq, rate, fast)):
        stood = near(found, samples, reach)
        if j not in but and stood.any():
            away = scipy.ndimage.distance_transform_edt(~stood)
            out[:, j] = np.sin(0.5 * np.pi * np.minimum(away / ramp, 1.0)) ** 2
    return out


def filtered(columns: Array, lowpass: Lowpass, share: Array | None) -> Array:
    """Columns (N, …) behind the low-pass; share: (N, …) factor of their equations, by the first
    axes of the columns; None for all of them."""
    if share is None:
        return lowpass(columns)
    if lowpass.channel is not None:
        flat = through_channel(columns.reshape(len(columns), -1), lowpass.channel, lowpass.rate)
        columns, lowpass = flat.reshape(columns.shape), replace(lowpass, channel=None)
    return lowpass(columns * share.reshape(share.shape + (1,) * (columns.ndim - share.ndim)))


def counted(share: Array, lowpass: Lowpass) -> NDArray[np.bool_]:
    """(M, n) filtered samples of which at least half stems from motion."""
    return np.asarray(lowpass.of_torque(share) > 0.5)
