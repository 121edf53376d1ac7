"""Which samples a fit may see and which it is judged on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.diagnose.constants import (
    FEWEST_TO_JUDGE,
    GUARD_PERIODS,
    LEAST_SEEN,
    PER_UNKNOWN,
    SIDE_BLOCKS,
)
from pa10d.diagnose.regression.side import Side
from pa10d.measurement.recording import Recording
from pa10d.measurement.standstill import NEVER_MOVES, REACH
from pa10d.model import TorqueModel
from pa10d.regression.equation import RunEquation, edge_time, prepare
from pa10d.regression.noisy_limits import with_limits
from pa10d.regression.per_joint import Mask

Array = NDArray[np.float64]


def two_sides(
    model: TorqueModel, fit: Sequence[Recording], validate: Sequence[Recording]
) -> tuple[Side, Side, str]:
    """Fit and held-out side, and in words what the judgement rests on.

    Runs that only stand on one side are used whole. Where nothing is left to validate on, or a
    run stands on both sides, it is cut into blocks of time that take turns.
    """
    if not fit:
        raise UserError("diagnose: no run to fit, expected at least one")
    _not_fitted_by_another_name(fit, validate)
    names = [r.name for r in fit]
    both = [r for r in validate if r.name in names]
    shared = list(both) if validate else list(fit)
    shared_names = {r.name for r in shared}
    train = [equation(model, r) for r in fit if r.name not in shared_names]
    held = [equation(model, r) for r in validate if r.name not in shared_names]
    uncut = [*train]
    for recording in shared:
        whole = equation(model, recording)
        first, second = blocks(whole)
        train.append(first)
        held.append(second)
        uncut.append(whole)
    if not shared:
        words = f"runs {', '.join(r.name for r in validate)}, which the fit has not seen"
    elif held and len(held) > len(shared):
        words = (
            f"runs {', '.join(r.name for r in validate)}; of {', '.join(sorted(shared_names))}, "
            "which the fit uses as well, every other block of time"
        )
    else:
        words = (
            f"every other block of time of {', '.join(sorted(shared_names))}; the blocks between "
            "were fitted (no separate validation run)"
        )
    silent = {**_idle(held, "to judge by"), **_idle(train, "to fit")}
    for j in silent.keys() - _idle(uncut, "").keys() if shared else ():
        silent[j] = _CUT.format(joint=j + 1)
    _some_left(silent, model.robot.n)
    _enough_to_fit(model, train)
    silent = {**_few_to_judge(held), **silent}
    _some_left(silent, model.robot.n)
    return Side.of(train), Side.of(held, silent), words


def _not_fitted_by_another_name(fit: Sequence[Recording], validate: Sequence[Recording]) -> None:
    """UserError where what is to judge was measured by what is fitted."""
    for run in validate:
        for other in fit:
            alike = np.array_equal(run.q, other.q) and np.array_equal(run.tau, other.tau)
            if run.name != other.name and alike:
                raise UserError(
                    f"diagnose: {run.name} has the samples of {other.name}, which is fitted; "
                    "expected another run to judge by, or none: then every other block of time "
                    "judges"
                )


_CUT = (
    "joint {joint} moves too little in blocks of time of one run, cut apart to fit to the ones and "
    "judge by the others: judge by another run (--validate), or use a longer one"
)


def _some_left(silent: Mapping[int, str], n: int) -> None:
    """UserError where nothing can be said of any of n joints; silent: of which not, and why."""
    if len(silent) == n:
        others = "; no other joint can be judged either" if n > 1 else ""
        raise UserError(f"diagnose: {silent[0]}{others}")


def _idle(side: Sequence[RunEquation], what: str) -> dict[int, str]:
    """Joints of which a side has no motion that the band can tell from standstills, and why."""
    idle = ~np.any([run.keep.any(axis=0) for run in side], axis=0)
    cutoff = side[0].lowpass.cutoff
    never = f"never moves in the data {what}: use runs in which it does"
    edge = edge_time(side[0].lowpass.rate, cutoff)
    ends = (
        f"moves only within {edge:.2g} s of the ends of the data {what}, where filters do not see "
        "both sides of it: use runs that go on for longer"
    )
    short = (
        f"turns round or stands so often in the data {what} that a band of {cutoff:.3g} Hz sees "
        f"nothing clear of that, expected strokes of {2.0 * REACH / cutoff:.2g} s and more: use "
        "such runs, or a model that was identified in a wider band"
    )
    hidden = (
        f"has a torque that is known nowhere in the data {what}: its channel mostly shows one "
        "value or a limit; record it finer, in a wider range and with power"
    )
    unknown = np.all([run.hidden for run in side], axis=0)
    whole, inner = (_reach(side, only_inside) > NEVER_MOVES for only_inside in (False, True))
    whys = [(unknown, hidden), (inner, short), (whole, ends)]
    return {
        j: f"joint {j + 1} {next((why for where, why in whys if where[j]), never)}"
        for j in np.flatnonzero(idle).tolist()
    }


def _reach(side: Sequence[RunEquation], only_inside: bool) -> Array:
    """(n,) rad or m: over how much joints move in one run, or clear of its ends."""
    moved = []
    for run in side:
        q = run.context.q
        q = q[:: run.lowpass.factor][run.inside] if only_inside else q
        moved.append(np.ptp(q, axis=0) if len(q) else np.zeros(q.shape[1]))
    return np.asarray(np.max(moved, axis=0))


def _enough_to_fit(model: TorqueModel, train: Sequence[RunEquation]) -> None:
    """Refuse data with so few independent samples that what the unknowns of the model are off by
    moves its torque by more than half of the noise's power."""
    needed, found = PER_UNKNOWN * len(model.covariance), float(np.sum(independent(train)))
    if found < needed:
        seconds = sum(float(run.keep.mean(axis=1).sum()) / run.rate for run in train)
        raise UserError(
            f"diagnose: {seconds:.2g} s of motion in the data to fit, too little for the "
            f"{len(model.covariance)} unknowns of {model.name}; expected {needed / found:.1f} "
            "times as much"
        )


def _few_to_judge(held: Sequence[RunEquation]) -> dict[int, str]:
    """Joints with too few independent samples to know their noise by, and how many: nothing is
    fitted to them, so the number of unknowns does not matter."""
    found = independent(held)
    return {
        int(j): f"{found[j]:.0f} independent samples of joint {j + 1} in motion in the data to "
        f"judge by, expected at least {FEWEST_TO_JUDGE}: a longer run of another motion, or a "
        "wider band (--cutoff)"
        for j in np.flatnonzero(found < FEWEST_TO_JUDGE)
    }


def independent(runs: Sequence[RunEquation]) -> Array:
    """(n,) samples that a band of the cut-off can hold in the time that counts: two a period."""
    return np.asarray(
        np.sum([2.0 * r.lowpass.cutoff / r.rate * r.keep.sum(axis=0) for r in runs], axis=0)
    )


def blocks(run: RunEquation) -> tuple[RunEquation, RunEquation]:
    """The run twice, each with every other block of time kept.

    Of a few numbers of blocks the one after which either side has seen most of what the whole run
    shows: with two blocks to a period, the one side would know its first half only and the other
    be judged on the second.
    """
    motion = _motions(run)
    cuts = [_taking_turns(run, number) for number in SIDE_BLOCKS]
    shares = [min(_least_share(motion, side) for side in cut) for cut in cuts]
    even, odd = cuts[int(np.argmax(np.round(shares, 6)))]  # none by a rounding error's lead
    return _within(run, even), _within(run, odd)


def _taking_turns(run: RunEquation, number: int) -> tuple[Mask, Mask]:
    """(M,) each: equally long blocks by turns, without what a filter carries over their seams."""
    samples = len(run.keep)
    block = np.arange(samples) * number // samples
    guard = int(np.ceil(GUARD_PERIODS / run.lowpass.cutoff * run.rate))
    seam = np.zeros(samples, dtype=bool)
    for start in np.flatnonzero(np.diff(block)) + 1:
        seam[max(0, start - guard) : start + guard] = True
    return (block % 2 == 0) & ~seam, (block % 2 == 1) & ~seam


def _motions(run: RunEquation) -> list[tuple[Mask, Array]]:
    """Per joint the rows (M,) that count and an orthonormal basis (rows, ≤ 6) of what its motion
    shows there: where it is, how fast, how it gathers speed."""
    step = run.lowpass.factor
    q, dq, ddq = (x[::step] for x in (run.context.q, run.context.dq, run.context.ddq))
    found = []
    for j, keep in enumerate(run.keep.T):
        x, v, a = q[keep, j], dq[keep, j], ddq[keep, j]
        shown = np.column_stack([np.ones(len(x)), x, x**2, v, v * np.abs(v), a])
        basis, sizes, _ = np.linalg.svd(shown / (np.abs(shown).max(axis=0, initial=1e-12)), False)
        found.append((keep, basis[:, sizes > LEAST_SEEN * sizes.max(initial=0.0)]))
    return found


def _least_share(motion: Sequence[tuple[Mask, Array]], side: Mask) -> float:
    """The least share of any direction of any joint's motion that a side (M,) sees."""
    shares = [1.0]
    for keep, basis in motion:
        seen = basis[side[keep]]
        shares.append(float(np.linalg.eigvalsh(seen.T @ seen)[0]) if basis.shape[1] else 1.0)
    return min(shares)


def _within(run: RunEquation, rows: Mask) -> RunEquation:
    """Nothing but these rows (M,) counts."""
    whole = rows[:, None]
    return replace(run, keep=run.keep & whole, moving=run.moving & whole, inside=run.inside & rows)


def equation(model: TorqueModel, recording: Recording) -> RunEquation:
    """A whole run in the model's band, each joint's equation where that joint moves."""
    if recording.joints != model.robot.n:
        raise UserError(
            f"{recording.name}: {recording.joints} joints, expected {model.robot.n} as in model "
            f"{model.name}"
        )
    run = with_limits(recording, model.robot)
    return prepare(run, model.robot, model.cutoff, model.shift, channel=model.channel, stands=False)
