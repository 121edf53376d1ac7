"""Both sides of τ = Y·h + Σ effects for one run, filtered alike and decimated.

Motion is filtered lightly at the raw rate; from it come all columns (regressor, sign functions,
memory effects), and columns and torque then pass the same zero-phase low-pass. Filtering the
ingredients instead of the columns would bend every product and every sign.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot, regressor
from pa10d.effects import Context
from pa10d.measurement.motion import VelocitySource, motion, quieting_of, velocity_source
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass, delayed, refuse_cutoff
from pa10d.measurement.standstill import RESTING, held, standstill
from pa10d.measurement.torque_filter import TorqueFilter
from pa10d.regression.rests import (
    FEWEST_MOVING,
    below_limits,
    counted,
    filtered,
    filtered_rows,
    going,
    rung_by,
)

Array = NDArray[np.float64]

MOTION_SHARE = 0.25  # of the sampling rate at most: beyond, a digital Butterworth rings at its end
MOTION_SETTLES = 8.0  # periods of the motion's cut-off after which twice-differentiated ends have
# decayed to 1e-6 (at the highest share of the rate) or 1e-8
NOT_BENT = 3.0  # times the equation's cut-off, up to which an acceleration is always motion: what
#   is given up beyond changes no torque within the band by more than 2e-4
OVERSAMPLING = 4.0  # samples kept per period of the cut-off: the filter is down to 0.4 % there
CLEAR = 0.9  # part of a filtered sample that has to stem from motion
MOTION_CUTOFF = 120.0  # Hz at most for the motion itself: a sign must see the reversal sharply


@dataclass(frozen=True)
class RunEquation:
    """One run, ready for fits.

    context  motion at the raw rate (model part empty until a model is known)
    lowpass  raw -> decimated, of columns; of_torque is for what was measured
    tau      (M, n) filtered torque
    keep     (M, n) False where joint i stands still, if only to turn round (friction is
             indeterminate there), or the sample is too near an end of the run
    moving   (M, n) as keep, but reversals without a rest count: what tells how sharp they are
    inside   (M,) False only near the ends, and where the run is left out
    used     (M,) False only where the run is left out, and too near to that
    going    (N, n) 0 where joint i stands or its torque stands at a limit, 1 clear of that: its
             equation is multiplied by it before anything is filtered
    stands   its equations hold where a joint stands, too
    shift    s, by which the torque was moved to match the motion
    angles   (N, n) as they were measured, of joints whose motion was made of them; nan of others
    """

    name: str
    context: Context
    lowpass: Lowpass
    tau: Array
    keep: NDArray[np.bool_]
    raw_tau: Array
    shift: float = 0.0
    moving: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0), dtype=bool))
    inside: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    used: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    going: Array | None = None
    angles: Array | None = None
    stands: bool = True

    @property
    def hidden(self) -> NDArray[np.bool_]:
        """(n,) True of joints whose torque is known nowhere in the run."""
        if self.going is None:
            return np.zeros(self.context.robot.n, dtype=bool)
        return np.asarray(~self.going.any(axis=0))

    @property
    def rate(self) -> float:
        """Decimated samples per second."""
        return self.lowpass.rate / self.lowpass.factor

    @cached_property
    def t(self) -> Array:
        """(M,) s since the start of the run."""
        return self.context.t[:: self.lowpass.factor]

    @cached_property
    def left(self) -> Array:
        """(M, n) what ``going`` leaves of the filter's weights, at least as much as counts: rows
        divided by it are as large beside a standstill as elsewhere (normalised convolution,
        Knutsson & Westin 1993, doi:10.1109/CVPR.1993.341081)."""
        if self.going is None:
            return np.ones_like(self.tau)
        return np.maximum(self.lowpass.of_torque(self.going), CLEAR)

    @cached_property
    def driven(self) -> Array:
        """(M, n) N·m: the measured side of each joint's equation, without where it stood."""
        return self.tau if self.going is None else self.of_torque(self.raw_tau)

    def of_torque(self, raw: Array) -> Array:
        """(N, n) of what was measured -> (M, n), as each joint's equation has it."""
        if self.going is None:
            return self.lowpass.of_torque(raw)
        return self.lowpass.of_torque(raw * self.going) / self.left

    def filtered(self, raw: Array, joint: int | None = None) -> Array:
        """The modelled side, (N, n, …) -> (M, n, …) of all joints or (N, …) -> (M, …) of one."""
        if self.going is None:
            return self.lowpass(raw)
        chosen = np.s_[:] if joint is None else np.s_[:, joint]
        return filtered(raw, self.lowpass, self.going[chosen], self.left[chosen])

    def later(self, seconds: float) -> RunEquation:
        """The same with its torque taken ``seconds`` later than it is now."""
        raw = delayed(self.raw_tau, -seconds, self.lowpass.rate)
        return replace(
            self, tau=self.lowpass.of_torque(raw), raw_tau=raw, shift=self.shift + seconds
        )

    def without_stands(self, fast: Array | None = None) -> RunEquation:
        """The same with each joint's equation multiplied by 0 where it stands; what hardly moves is
        left as it is. fast: (n,) rad/s, what counts as fast for each joint."""
        rested = self.moving.sum(axis=0) < FEWEST_MOVING
        share = going(self.context.dq, self.lowpass, fast, but=np.flatnonzero(rested))
        share = share if self.going is None else share * self.going
        moves = self.counts & counted(share, self.lowpass, CLEAR)
        keep = np.where(rested, self.keep, moves)
        return replace(self, going=share, keep=keep, moving=self.moving | keep, stands=False)

    @cached_property
    def counts(self) -> NDArray[np.bool_]:
        """(M, n) all samples of joints that are not held, clear of the ends."""
        units = [self.context.robot.torque_unit(j) for j in range(self.context.robot.n)]
        return self.inside[:, None] & ~held(self.context.q, units)

    def rigid_columns(self, kept: NDArray[np.int64]) -> Array:
        """(M, n, b) filtered regressor columns of the kept standard parameters."""
        robot = self.context.robot
        seen = robot.carries()[:, kept // 10]
        out = np.zeros((self.lowpass.kept, robot.n, len(kept)))
        for j, columns in enumerate(self.rigid_rows(kept, seen)):
            out[:, j, seen[j]] = columns
        return out

    def rigid_rows(
        self, kept: NDArray[np.int64], seen: NDArray[np.bool_], raw: Array | None = None
    ) -> list[Array]:
        """Per joint (M, k_j): the filtered columns of ``kept`` that its equation has at all.

        seen (n, b): which ones those are (a link's parameters only load joints that carry it);
        raw: what ``raw_rigid`` gave, where it is at hand.
        """
        raw = self.raw_rigid(kept) if raw is None else raw
        rows, chosen = raw.reshape(-1, raw.shape[2]), np.flatnonzero(seen)
        if self.going is None:
            found = self.lowpass.of_rows(rows, chosen)
        else:
            joints = chosen // seen.shape[1]
            going, left = self.going.T[joints], self.left[:, joints]
            found = filtered_rows(rows[chosen], self.lowpass, going, left)
        return np.split(found, np.cumsum(seen.sum(axis=1))[:-1], axis=1)

    def raw_rigid(self, kept: NDArray[np.int64]) -> Array:
        """(n, b, N) unfiltered regressor columns, samples last: the order the filter wants."""
        c = self.context
        samples, n = c.q.shape
        raw = np.zeros((n, len(kept), samples))
        regressor(c.robot, c.q, c.dq, c.ddq, kept, out=raw.transpose(2, 0, 1))
        return raw


def prepare(
    recording: Recording,
    robot: Robot,
    cutoff: float,
    shift: float = 0.0,
    edge: float | None = None,
    fast: Array | None = None,
    source: VelocitySource | None = None,
    channel: TorqueFilter | None = None,
    stands: bool = True,
) -> RunEquation:
    """Make one run ready: differentiate, filter, mask.

    cutoff: Hz of the equation; shift: s by which the torque channel is late against position;
    edge: s cut off at both ends (default: what the filters need to settle);
    fast: (n,) rad/s, what counts as fast for each joint (default: from this recording);
    source: which velocities to trust (default: from this recording);
    channel: what the torque channel has passed: columns pass it, too;
    stands: whether equations hold where their joint stands, too (they do, but for its friction).
    """
    rate = recording.rate
    light = Lowpass(len(recording.t), rate, motion_band(rate, cutoff))
    source = source or velocity_source(recording, cutoff)
    q, dq, ddq = motion(recording, light, source)
    factor = decimation(rate, cutoff)
    blind = int(np.ceil(MOTION_SETTLES / light.cutoff * rate))
    lowpass = Lowpass(len(recording.t), rate, cutoff, factor, blind=blind, channel=channel)
    tau = recording.tau if shift == 0.0 else delayed(recording.tau, -shift, rate)
    ends = int(np.ceil((edge if edge is not None else edge_time(rate, cutoff)) * rate / factor))
    inside = np.zeros(lowpass.kept, dtype=bool)
    inside[ends : max(ends, lowpass.kept - ends)] = True
    used = _used(recording.left_out, lowpass)
    inside &= used
    counts = inside[:, None] & ~held(q, [robot.torque_unit(j) for j in range(robot.n)])
    keep = counts & ~standstill(dq, rate, lowpass, fast)
    moving = counts & ~standstill(dq, rate, lowpass, fast, RESTING)
    known = below_limits(recording.clipped, lowpass, shift)
    if known is not None:
        rung = rung_by(known, lowpass)
        keep, moving = keep & ~rung, moving & ~rung
    context = Context(
        robot=robot,
        t=recording.t - recording.t[0],
        q=q,
        dq=dq,
        ddq=ddq,
        rigid=np.zeros((robot.n, 10)),
        total=np.zeros_like(q),
        temperature=recording.temperature,
        quieting=quieting_of(ddq, rate, NOT_BENT * cutoff, light.cutoff),
    )
    whole = RunEquation(
        recording.name,
        context,
        lowpass,
        lowpass.of_torque(tau),
        keep,
        tau,
        shift,
        moving,
        inside,
        used,
        known,
        angles=np.where(source.reported, np.nan, recording.q),
    )
    return whole if stands else whole.without_stands(fast)


def _used(left_out: NDArray[np.bool_], lowpass: Lowpass) -> NDArray[np.bool_]:
    """(M,) False where the run is left out, and as far from there as the filter settles."""
    used = np.ones(lowpass.kept, dtype=bool)
    for k in np.unique(np.flatnonzero(left_out) // lowpass.factor):
        used[max(0, k - lowpass.settle) : k + lowpass.settle + 2] = False
    return used


def decimation(rate: float, cutoff: float) -> int:
    """How many raw samples make one of the equation's; a rate worked out from stamps may be a
    rounding error below the true one."""
    refuse_cutoff(cutoff, rate)
    return max(1, int(rate / (OVERSAMPLING * cutoff) * (1 + 1e-6)))


def motion_band(rate: float, cutoff: float) -> float:
    """Hz: low-pass of the motion itself, where an equation is cut off at ``cutoff``."""
    return min(max(MOTION_CUTOFF, 2.0 * cutoff), MOTION_SHARE * rate)


def edge_time(rate: float, cutoff: float) -> float:
    """s at each end that still know how the signal was continued beyond it.

    The slowest pole of a 4th-order Butterworth decays with 2π·f·sin(π/8): after 3 periods of the
    equation's cut-off to 1e-3; the motion's are MOTION_SETTLES.
    """
    refuse_cutoff(cutoff, rate)
    return 3.0 / cutoff + MOTION_SETTLES / motion_band(rate, cutoff)
