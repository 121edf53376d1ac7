"""Where a torque stands at a limit that noise hides: only the motion tells that it does.

A limit before the noise shows no value twice, and a smooth peak, or dry friction alone, is as flat
for a while. But the motion would ask for more, and for different amounts at different times, where
the torque comes to the same top again and again. So each joint's textbook equation is fitted
without the samples near its top, and foretells those. Where one end is a limit, the same torque the
other way is its other end, be it come to but once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import scipy.ndimage
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.effects.base import smooth_sign
from pa10d.measurement.clipped import FEWEST
from pa10d.measurement.recording import Recording
from pa10d.measurement.spans import spans
from pa10d.model.notes import TorqueEndNote
from pa10d.regression.equation import RunEquation, prepare
from pa10d.regression.layout import textbook

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

MEAN_OVER = 0.02  # s, and at least FEWEST_MEANT samples: noise is less in a mean over them
FEWEST_MEANT = 5
BAND = 8.0  # standard errors of such a mean, between the highest and the lowest at a limit
NARROW = 0.05  # of the torque's range: in a wider band noise is all there is
LOWEST = 3.0  # standard errors of one sample
SEPARATE = 3  # times that the same top is come to
BEYOND = 4.0  # standard errors that a motion asks for more, in most of the samples there
ASKED = 10.0  # bands by which what is asked for differs from time to time
CUTOFF = 10.0  # Hz, of the equations
SHARE = 0.05  # of the sampling rate, where that is less
SLOWEST_SIGN = 0.01  # rad/s
PER_UNKNOWN = 3.0  # samples of the fit
MOST = 900_000  # samples: half an hour at 500 Hz; of longer runs this is not asked


@dataclass(frozen=True, eq=False)
class NoisyLimit:
    """joint: from 0; level: N·m (N); largest: the upper end; at (N,): samples there."""

    joint: int
    level: float
    largest: bool
    at: Flags


def with_limits(
    recording: Recording, robot: Robot, known: Iterable[TorqueEndNote] = ()
) -> Recording:
    """The recording, which knows where torques stand at limits that noise hides.

    known: what other runs of that arm proved
    """
    (recording,) = sharing_limits([recording], robot, known)
    found = noisy_limits(recording, robot)
    if not found:
        return recording
    limited = recording.clipped.copy()
    for one in found:
        limited[:, one.joint] |= one.at
    seen = replace(recording, limited=limited)
    vars(seen)[_KEPT] = (robot, ())
    return seen


def noisy_limits(recording: Recording, robot: Robot) -> tuple[NoisyLimit, ...]:
    """Of a run that is in memory; looked for once per recording and robot."""
    if type(recording) is not Recording or len(recording.t) > MOST or recording.joints != robot.n:
        return ()  # on disk, long, or of another arm
    known = vars(recording).get(_KEPT)
    if known is None or known[0] is not robot:
        known = vars(recording)[_KEPT] = (robot, tuple(_found(recording, robot)))
    return cast(tuple[NoisyLimit, ...], known[1])


_KEPT = "_noisy_limits"


def torque_ends(recordings: Iterable[Recording], robot: Robot) -> tuple[TorqueEndNote, ...]:
    """Each end of a torque channel that some of one arm's runs prove."""
    found = {
        (one.joint, one.largest): TorqueEndNote(one.joint + 1, one.level, one.largest)
        for run in recordings
        for one in noisy_limits(run, robot)
    }
    return tuple(found.values())


def sharing_limits(
    recordings: Sequence[Recording], robot: Robot, known: Iterable[TorqueEndNote] = ()
) -> list[Recording]:
    """The runs, which know each other's limits: one that one run proves ends the torque of the
    others, too, be it come to but once there. One arm's runs, with one sensor.

    known: what earlier runs of that arm proved
    """
    ends = [*known, *torque_ends(recordings, robot)]
    proven = {(one.joint - 1, one.largest): one.level for one in ends}
    out = []
    for run in recordings:
        its = noisy_limits(run, robot)
        others = {k: v for k, v in proven.items() if k not in {(n.joint, n.largest) for n in its}}
        more = tuple(_at_known(run, others)) if _KEPT in vars(run) else ()  # else: too long
        if more:
            run = replace(run)
            vars(run)[_KEPT] = (robot, its + more)
        out.append(run)
    return out


def _at_known(run: Recording, proven: Mapping[tuple[int, bool], float]) -> Iterator[NoisyLimit]:
    for (j, largest), level in proven.items():
        side = 1.0 if largest else -1.0
        top = _top(side * run.tau[:, j], run.rate, 1)
        if top is not None and abs(side * top.level - level) < top.band:
            yield _limit(j, side, top, run)


def _found(recording: Recording, robot: Robot) -> Iterator[NoisyLimit]:
    shown = recording.clipped
    tops = {
        (j, side): top
        for j in range(recording.joints)
        for side in (1.0, -1.0)
        if (top := _top(side * recording.tau[:, j], recording.rate)) is not None
        and not (top.at & shown[:, j]).any()
    }
    if not tops:
        return
    near = shown.copy()
    for (j, _), top in tops.items():
        near[:, j] |= top.at
    cutoff = min(CUTOFF, SHARE * recording.rate)
    apart, plain = (
        prepare(replace(recording, limited=one), robot, cutoff, stands=stands)
        for one, stands in ((near, False), (np.zeros_like(near), True))
    )
    layout = textbook(robot)
    rows = [run.rigid_rows(layout.base.kept, layout.seen) for run in (apart, plain)]
    for (j, side), top in tops.items():
        asked = _asked(j, side, (apart, plain), (rows[0][j], rows[1][j]))
        if asked is not None and _is_limit(top, *asked, apart.lowpass.factor):
            yield _limit(j, side, top, recording)
            other = _top(-side * recording.tau[:, j], recording.rate, 1)
            alike = other is not None and abs(other.level - top.level) < top.band
            if other is not None and alike and (j, -side) not in tops:
                yield _limit(j, -side, other, recording)


def _limit(j: int, side: float, top: _Top, recording: Recording) -> NoisyLimit:
    at = top.at | (side * recording.tau[:, j] > top.lowest)
    return NoisyLimit(j, side * top.level, side > 0, at)


@dataclass(frozen=True)
class _Top:
    """at: (N,) where a torque is at the top of what it comes to; level: N·m there; band: N·m within
    which noise leaves a mean there; lowest: N·m that noise leaves a sample there."""

    at: Flags
    level: float
    band: float
    lowest: float


def _top(values: Array, rate: float, times: int = SEPARATE) -> _Top | None:
    """Of a torque (N,); None where it is no candidate for a limit, to which it comes so often."""
    over = max(FEWEST_MEANT, int(MEAN_OVER * rate))
    if len(values) < 10 * over:
        return None
    noise = 1.4826 * float(np.median(np.abs(np.diff(values, 2)))) / np.sqrt(6.0)
    mean = scipy.ndimage.uniform_filter1d(values, over, mode="nearest")
    band = BAND * noise / np.sqrt(over)
    if not 0.0 < band < NARROW * float(np.ptp(mean)):
        return None
    at = mean >= mean.max() - band
    long = [(k, end) for k, end in spans(at) if end - k >= over]
    if len(long) < times or np.diff(long).sum() < FEWEST * over * times // SEPARATE:
        return None
    out = np.zeros(len(values), dtype=bool)
    for k, end in long:
        out[max(0, k - over) : end + over] = True
    level = float(values[at].mean())
    return _Top(out, level, band, level - LOWEST * noise)


def _asked(
    j: int, side: float, runs: tuple[RunEquation, RunEquation], rigid: tuple[Array, Array]
) -> tuple[Array, Array] | None:
    """(M,) N·m that the motion asks for beyond what joint j shows, and its standard errors."""
    apart, plain = runs
    fitted, foretold = (
        np.column_stack([rows, run.filtered(_friction(run, j), j)])
        for run, rows in zip(runs, rigid, strict=True)
    )
    keep = apart.keep[:, j]
    if keep.sum() < PER_UNKNOWN * fitted.shape[1]:
        return None
    scale = np.linalg.norm(fitted[keep], axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    u, s, v = np.linalg.svd(fitted[keep] / scale, full_matrices=False)
    sure = s > 1e-6 * s[0]
    beta = v[sure].T @ ((u[:, sure].T @ apart.driven[keep, j]) / s[sure])
    left = apart.driven[keep, j] - fitted[keep] / scale @ beta
    per = 2.0 * apart.lowpass.cutoff / apart.rate  # independent samples of one
    unit = float(left @ left) / max(1.0, len(left) - sure.sum() / per)
    far = ((foretold / scale) @ v[sure].T / s[sure]) ** 2
    error = np.sqrt(unit * (1.0 + far.sum(axis=1) / per))
    return side * (foretold / scale @ beta - plain.tau[:, j]), error


def _friction(run: RunEquation, j: int) -> Array:
    """(N, 4) columns of a joint's rotor, its friction and an offset."""
    dq, ddq = run.context.dq[:, j], run.context.ddq[:, j]
    return np.column_stack([ddq, smooth_sign(dq, SLOWEST_SIGN), dq, np.ones_like(dq)])


def _is_limit(top: _Top, asked: Array, error: Array, factor: int) -> bool:
    """Does the motion ask for more, and for different amounts, where the torque is at its top?"""
    inner = spans(top.at[::factor][: len(asked)])
    if len(inner) < SEPARATE:
        return False
    beyond = np.concatenate([(asked / error)[k:end] for k, end in inner])
    most = np.array([asked[k:end].max() for k, end in inner])
    return bool(np.mean(beyond > BEYOND) > 0.5 and np.ptp(most) > ASKED * top.band)
