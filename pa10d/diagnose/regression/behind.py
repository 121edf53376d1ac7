"""How the torque of a model moves with the channel that it is recorded through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import SLOPE_STEP
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.identify.channel import LEAST_DELAY
from pa10d.measurement.signals import through_channel
from pa10d.measurement.torque_filter import DELAYS, FIRST_ORDER, TorqueFilter
from pa10d.regression.per_joint import PerJoint
from pa10d.regression.winding import seen_by

Array = NDArray[np.float64]


def torque_of(state: SearchState) -> list[Array]:
    """(N, n) N·m per run of the fit side, as it is before the channel."""
    return [state.model.sensed(seen_by(state.model, run)) for run in state.train.runs]


def moved_by(
    state: SearchState, torque: list[Array], to: TorqueFilter | None, since: TorqueFilter | None
) -> PerJoint:
    """joint -> (m_j, 1) weighted: a model's torque (N, n) per run behind one channel, less what it
    is behind another."""
    changes = [
        through_channel(one, to, run.lowpass.rate) - through_channel(one, since, run.lowpass.rate)
        for run, one in zip(state.train.runs, torque, strict=True)
    ]
    return _weighted(state, recorded(state.train, changes))


def recorded(side: Side, torque: list[Array]) -> PerJoint:
    """joint -> (m_j, 1) N·m, of (N, n) per run as it comes out of the channel."""
    rows = [
        replace(run, lowpass=replace(run.lowpass, channel=None)).filtered(one)
        for run, one in zip(side.runs, torque, strict=True)
    ]
    return {j: side.gathered([one[:, j : j + 1] for one in rows], j) for j in range(side.n)}


def _weighted(state: SearchState, rows: PerJoint) -> PerJoint:
    return {j: own / state.fit.sigma[j] for j, own in rows.items()}


def channel_slopes(state: SearchState) -> PerJoint:
    """joint -> (m_j, s) weighted: how the model's torque moves with what it is late by, per second,
    and with the channel's own time, where that is known; (m_j, 0) of a model that stays as it was,
    which knows its own. An offset in time that was not taken out is as unsure as it was found."""
    channel = state.train.runs[0].lowpass.channel
    if state.frozen:
        return _none(state)
    torque = torque_of(state)
    rates = [
        -np.gradient(through_channel(one, channel, run.lowpass.rate), axis=0) * run.lowpass.rate
        for run, one in zip(state.train.runs, torque, strict=True)
    ]
    late = _weighted(state, recorded(state.train, rates))
    if channel is None:
        return late
    step = SLOPE_STEP * channel.seconds
    ends = [replace(channel, seconds=channel.seconds + way * step) for way in (1.0, -1.0)]
    own = moved_by(state, torque, *ends)
    return {j: np.column_stack([own[j] / (2.0 * step), late[j]]) for j in own}


def perhaps_smoothed(state: SearchState) -> PerJoint:
    """joint -> (m_j, 1) weighted: what the model's torque moves by if what makes the channel late
    is a low-pass after all; (m_j, 0) where it is not late, or its low-pass is known."""
    if not _smoothed_perhaps(state):
        return _none(state)
    to = TorqueFilter(FIRST_ORDER, state.train.runs[0].shift / DELAYS[FIRST_ORDER])
    return moved_by(state, torque_of(state), to, None)


def _smoothed_perhaps(state: SearchState) -> bool:
    first = state.train.runs[0]
    late = first.shift * first.lowpass.cutoff
    return not state.frozen and first.lowpass.channel is None and late >= LEAST_DELAY


def _none(state: SearchState) -> PerJoint:
    return {j: basis[:, :0] for j, basis in state.fit.basis.items()}
