"""What noise of the angles makes of a model's squared error, behind one torque channel or another.

A prediction from noisy angles is noisy, and the softer the channel that it passes the less of that
is left: squared errors alone ask for a softer channel than there is, and motion held out agrees. So
what the same noise once more on the same motion makes is taken off first, as in a corrected score
(Nakamura, Biometrika 77, 1990; the noise once more: Cook & Stefanski, Journal of the American
Statistical Association 89, 1994).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.regression.behind import recorded
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.judgement.encoder import once_more
from pa10d.measurement.signals import through_channel
from pa10d.measurement.torque_filter import TorqueFilter
from pa10d.regression.per_joint import PerJoint
from pa10d.regression.winding import seen_by

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Shaken:
    """side: of which; draws: each (N, n) N·m per run, as they are before the channel."""

    side: Side
    draws: list[list[Array]]

    def behind(self, channel: TorqueFilter | None) -> list[PerJoint]:
        """joint -> (m_j, 1) N·m of each draw, as it comes out of such a channel."""
        rates = [run.lowpass.rate for run in self.side.runs]
        return [
            recorded(
                self.side, [through_channel(x, channel, r) for x, r in zip(one, rates, strict=True)]
            )
            for one in self.draws
        ]

    def squares(self, channel: TorqueFilter | None) -> Array:
        """(n,) (N·m)², summed over the samples that count."""
        each = [[np.sum(rows[j] ** 2) for j in range(self.side.n)] for rows in self.behind(channel)]
        return np.mean(each, axis=0) if each else np.zeros(self.side.n)


def shaken(state: SearchState, side: Side) -> Shaken:
    """No draw where noise of the angles is no more than a slight part of what any joint leaves."""
    left, model = state.fit.rms(), state.model
    each = [once_more(model, seen_by(model, run), run, left) for run in side.runs]
    return Shaken(side, [list(draw) for draw in zip(*each, strict=True)] if all(each) else [])


def made_held_out(state: SearchState) -> Array:
    """(n,) (N·m)², mean square that noise of the angles makes of each joint's error there."""
    made = shaken(state, state.held).squares(state.train.runs[0].lowpass.channel)
    return made / np.array([max(len(tau), 1) for tau in state.held.tau])
