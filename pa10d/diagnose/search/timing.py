"""One timing offset between torque and position, common to the whole robot.

A torque held over a sample period is half a period late, stamps come from different clocks: such
an offset shows in every joint alike and is no finding. It is taken out before the search, as the
weighted median over the joints, so that a delay of one joint alone stays where it is. Where an
encoder's noise is more than the motion, only the motion is asked: a servo answers both, each with a
delay of its own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    MATERIAL_GAIN,
    TIMING_AGREE,
    TIMING_MOST_SAMPLES,
    TIMING_ROUNDS,
    TIMING_SIGNIFICANT,
)
from pa10d.diagnose.evidence.held_out import quadratic_form
from pa10d.diagnose.regression.partial import partials, solve_symmetric
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.shape_slopes import shape_slopes
from pa10d.effects import effect
from pa10d.identify.timing import FARTHEST
from pa10d.judgement.encoder import less_noise
from pa10d.measurement.encoder_noise import motion_up_to
from pa10d.measurement.signals import Lowpass
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]


def align(state: SearchState, contradicting: bool = False, shapes: bool = False) -> float:
    """Take the common offset out of both sides; returns it in s (0 where insignificant). A frozen
    model brings its own timing: nothing there may be explained by moving it.

    contradicting: also where the joints ask for different ones, if it helps nearly all of them;
    shapes: of what was found may move along. Either is asked beside what was found, which may have
    kept identification from any offset: that is no correction of one, and may be as large.
    """
    taken = 0.0
    if state.frozen:
        return taken
    for _ in range(TIMING_ROUNDS):
        along = (shape_slopes(state),) if shapes else ()
        delays, errors = joint_delays(state, *along)
        offset, error = weighted_median(delays, errors)
        if abs(offset) < TIMING_SIGNIFICANT * error:
            break
        correction = TIMING_MOST_SAMPLES / state.train.runs[0].lowpass.rate
        if abs(taken + offset) > (FARTHEST if contradicting or shapes else correction):
            break
        before = sizes(state)
        move(state, offset)
        after = sizes(state)
        # what the fit side asks for must hold on the other side too, and where the arm turns round
        better = np.all(after.sum(axis=1) <= before.sum(axis=1))
        agreed = shared(offset, delays, errors) or (contradicting and _helps(before, after))
        if not better or not agreed:
            move(state, -offset)
            break
        taken += offset
        if abs(offset) < 2e-5:
            break
    return taken


def late_joints(state: SearchState, first: int) -> list[int]:
    """Which of the terms from ``first`` on say that a joint's torque is measured late."""
    terms = state.terms
    return [k for k in range(first, len(terms)) if terms[k].effect_id == "torque_delay"]


def move(state: SearchState, seconds: float) -> None:
    """Torque is taken so much later than it was."""
    state.train, state.held = state.train.shifted(seconds), state.held.shifted(seconds)
    state.refit()


def sizes(state: SearchState, made: Array | None = None) -> Array:
    """(2, k): logarithms of judged joints' squared held-out errors, without and with reversals;
    made: (n,) (N·m)² that noise of the angles makes of them, which does not count then."""
    residual = state.held_residual()
    judged = [j for j in range(state.held.n) if len(residual[j])]
    without = [np.mean(residual[j] ** 2) for j in judged]
    square: Array = np.array([without, state.moving_rms()[judged] ** 2], dtype=float)
    return np.log(square if made is None else less_noise(square, made[judged]))


def _helps(before: Array, after: Array) -> bool:
    """Does an offset make most joints' held-out errors materially smaller and none larger, whatever
    the joints would ask for themselves? What the model lacks on one joint bends the bodies that
    all share, and with them the delays that the others ask for."""
    less = after < before + 2.0 * np.log(1.0 - MATERIAL_GAIN)
    return bool(np.all(after <= before) and np.mean(less) > TIMING_AGREE)


def joint_delays(state: SearchState, shapes: PerJoint | None = None) -> tuple[Array, Array]:
    """(n,) s: each joint's own best delay beside the present model, and its standard error; shapes:
    ``shape_slopes`` along which what was found may move."""
    kind, n = effect("torque_delay"), state.train.n
    shapes = shapes or {j: basis[:, :0] for j, basis in state.fit.basis.items()}
    gram = np.sum([s.T @ s for s in shapes.values()], axis=0)
    delays, errors = np.zeros(n), np.full(n, np.inf)
    residual = state.train.scatter(state.train_residual())
    motion = motion_up_to([(run.context.q, run.lowpass.rate) for run in state.train.runs])
    for j in range(n):
        columns = state.train.columns(kind, (j,), [{}])
        one = partials(state.fit, columns, kind, 1)[0]
        if not one.identifiable:
            continue
        own = columns[j][:, 0] / state.fit.sigma[j]
        left = own - state.fit.basis[j] @ one.seen[:, 0]
        if gram.size:
            left = left - shapes[j] @ solve_symmetric(gram, shapes[j].T @ own)
        asked = _slow(state, j, left, motion)  # an instrumental variable, if it is not left itself
        knows = float(asked @ left)
        if knows <= 0.0:
            continue
        delays[j] = asked @ state.fit.residual[j] / knows
        per_run = state.train.scatter({j: asked})
        variance = sum(
            quadratic_form(p[:, j], r[:, j] / state.fit.sigma[j], k[:, j], run.rate)
            for p, r, k, run in zip(
                per_run, residual, state.train.keep, state.train.runs, strict=True
            )
        )
        errors[j] = np.sqrt(variance) / knows
    return delays, errors


def _slow(state: SearchState, joint: int, rows: Array, band: float) -> Array:
    """What is left of rows (m_j,) of one joint below ``band`` Hz, and by the model."""
    if band >= state.train.runs[0].lowpass.cutoff:
        return rows
    stretches = state.train.stretches(joint, rows)
    slow = [
        Lowpass(len(x), run.rate, band)(x)[keep]
        for (x, keep), run in zip(stretches, state.train.runs, strict=True)
    ]
    found, basis = np.concatenate(slow), state.fit.basis[joint]
    return np.asarray(found - basis @ (basis.T @ found))


def shared(offset: float, delays: Array, errors: Array) -> bool:
    """Do most joints agree with a common offset, and rather with it than with none? Structure of
    another kind pulls them apart, and who may as well say nothing is no witness."""
    usable = np.isfinite(errors) & (errors > 0)
    room = np.maximum(3.0 * errors[usable], 0.5 * abs(offset))
    off = np.abs(delays[usable] - offset)
    agree = (off < room) & (off < np.abs(delays[usable]))
    weight = np.minimum(1.0 / errors[usable], 3.0 / np.median(errors[usable]))
    return bool(weight[agree].sum() > TIMING_AGREE * weight.sum())


def weighted_median(values: Array, errors: Array) -> tuple[float, float]:
    """Median with weights 1/error (no joint counts for more than a third), and its error."""
    weight = np.where(np.isfinite(errors) & (errors > 0), 1.0 / np.maximum(errors, 1e-300), 0.0)
    if weight.sum() == 0:
        return 0.0, np.inf
    share = max(1.0 / 3.0, 1.0 / np.count_nonzero(weight))
    for _ in range(60):  # what is cut off one joint lowers the total, and so the cap
        weight = np.minimum(weight, share * weight.sum())
    order = np.argsort(values)
    below = np.cumsum(weight[order]) / weight.sum()
    middle = float(values[order][np.searchsorted(below, 0.5)])
    spread = 1.2533 / np.sqrt(np.sum(1.0 / errors[np.isfinite(errors)] ** 2))
    return middle, float(spread)
