"""Measured minus modelled torque of one run, filtered and raw, and where it counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.effects import Context
from pa10d.judgement.bent_before import bent_before
from pa10d.judgement.encoder import of_angles
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import through_channel
from pa10d.model import TorqueModel
from pa10d.regression.equation import RunEquation, prepare
from pa10d.regression.noisy_limits import with_limits
from pa10d.regression.rests import FEWEST_MOVING
from pa10d.regression.shared_surfaces import sharing, where_shared_slips
from pa10d.regression.winding import seen_by

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class RunResidual:
    """One run seen by one model.

    seen       motion at the raw rate with the model's loads and torque
    measured, modelled  (M, n) N·m, both through the equation's low-pass, decimated
    raw_error  (N, n) N·m, unfiltered measured torque minus prediction
    counts     (M, n) True where joint i moves, reversals included (there friction models fail),
               away from the run's ends, and not where bristles are bent as the run found them:
               where an error is looked for
    judged     (M, n) the same clear of reversals, and of moments in which what joints share sticks:
               where its size is judged
    rested     joints (0-based) that hardly moved: judged over the whole run instead
    bent       joints (0-based) of which a beginning does not count: see ``bent_before``
    sharing    joints (0-based) that share surfaces in the model
    model      that sees it
    """

    name: str
    equation: RunEquation
    seen: Context
    measured: Array
    modelled: Array
    raw_error: Array
    counts: Mask
    judged: Mask
    rested: tuple[int, ...]
    bent: tuple[int, ...]
    sharing: tuple[int, ...]
    model: TorqueModel

    @property
    def hidden(self) -> tuple[int, ...]:
        """Joints (0-based) whose torque is known nowhere: what they leave says nothing."""
        return tuple(np.flatnonzero(self.equation.hidden).tolist())

    @cached_property
    def error(self) -> Array:
        """(M, n) N·m, filtered; clear of reversals without what the low-pass would carry there from
        a standstill, which nobody can predict."""
        whole, equation = self.measured - self.modelled, self.equation
        return np.where(equation.keep, equation.of_torque(self.raw_error), whole)

    @cached_property
    def raw_counts(self) -> Mask:
        """(N, n): ``counts`` at the raw rate."""
        return self._raw(self.counts)

    @cached_property
    def raw_judged(self) -> Mask:
        """(N, n): ``judged`` at the raw rate."""
        return self._raw(self.judged)

    @cached_property
    def of_angles(self) -> tuple[Array, Array]:
        """(n,) N·m RMS that noise of the angles makes of the error, 0 where it is next to nothing,
        and standard errors."""
        return of_angles(
            self.model, self.seen, self.equation, self.modelled, self.error, self.judged
        )

    def _raw(self, mask: Mask) -> Mask:
        factor = self.equation.lowpass.factor
        return np.repeat(mask, factor, axis=0)[: len(self.raw_error)]

    def decimated(self, raw: Array) -> Array:
        """Every raw sample (N, …) that has a filtered counterpart, (M, …)."""
        return raw[:: self.equation.lowpass.factor]


def run_residual(model: TorqueModel, recording: Recording) -> RunResidual:
    """Predict the run's torque at the raw rate, then filter both sides alike."""
    if recording.joints != model.robot.n:
        raise UserError(
            f"run {recording.name!r} has {recording.joints} joints, "
            f"expected {model.robot.n} as in model {model.name!r}"
        )
    run = with_limits(recording, model.robot, model.notes.torque_ends)
    equation = prepare(
        run, model.robot, model.cutoff, model.shift, channel=model.channel, stands=False
    )
    return residual_of(model, equation)


def residual_of(model: TorqueModel, equation: RunEquation) -> RunResidual:
    """The same of a run whose torque was filtered already."""
    equation = where_shared_slips(equation, model.terms)
    seen = seen_by(model, equation)
    predicted, low = model.sensed(seen), equation.lowpass
    counts, clear, rested = _judged(equation)
    unknown = bent_before(seen, equation.lowpass)
    unknown &= (clear & ~unknown).sum(axis=0) >= FEWEST_MOVING
    counts, clear = counts & ~unknown, clear & ~unknown
    return RunResidual(
        name=equation.name,
        equation=equation,
        seen=seen,
        measured=equation.tau,
        modelled=low(predicted),
        raw_error=equation.raw_tau - through_channel(predicted, low.channel, low.rate),
        counts=counts,
        judged=clear,
        rested=rested,
        bent=tuple(np.flatnonzero(unknown.any(axis=0)).tolist()),
        sharing=sharing(equation, model.terms),
        model=model,
    )


def hidden_in(runs: Sequence[RunResidual]) -> list[int]:
    """Joints (0-based) whose torque is known nowhere in any of the runs; none of no runs."""
    return sorted(set.intersection(*(set(run.hidden) for run in runs))) if runs else []


def _judged(equation: RunEquation) -> tuple[Mask, Mask, tuple[int, ...]]:
    """Where errors are looked for and judged; a joint that never moves is better judged at rest
    than not at all, and one that only turns round where it does."""
    counts = equation.moving.copy()
    rested = tuple(int(j) for j in np.flatnonzero(counts.sum(axis=0) < FEWEST_MOVING))
    ends = min(equation.lowpass.settle, (len(counts) - 1) // 2)
    counts[ends : len(counts) - ends, rested] = True
    counts &= equation.used[:, None]
    if counts.sum(axis=0).min() < FEWEST_MOVING:
        raise UserError(
            f"run {equation.name!r}: {equation.context.t[-1]:.2g} s are too short for a cut-off of "
            f"{equation.lowpass.cutoff:g} Hz, expected at least {6 / equation.lowpass.cutoff:.2g} s"
        )
    clear = equation.keep.copy()
    turning = clear.sum(axis=0) < FEWEST_MOVING
    clear[:, turning] = counts[:, turning]
    return counts, clear, rested
