"""One shift in time between torque and position for the whole robot.

A torque that is read later than the angle, held over a sample, or low-passed by its sensor
arrives late; so does an angle that passes a slower bus. Beside all other unknowns each joint gets a
delay of its own, by the first-order change -s·τ̇, away from reversals in time and in way: what
friction does there would pose as a delay. The robot's shift is their median, weighted by what each
joint knows, so that one joint with a delay of its own does not move it.

A delay is the same for slow and fast parts of the motion. What a model lacks is mostly slow and
poses as another delay there. Where differenced samples, which weigh fast parts more, say otherwise
(Hausman 1978, doi:10.2307/1913827), theirs is taken, if it is significant by itself, and both are
told: a low-pass of the torque delays fast parts less, too.

A servo answers what its encoder gets wrong, and it answers with a delay of its own: where that is
much of the torque, it poses as the channel's. So only as much of the band is heard as motion fills.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.identify.blocks import Pieces
from pa10d.identify.jackknife import moved_by_stretches, without_each
from pa10d.identify.loads import first_model
from pa10d.identify.piece import Piece
from pa10d.identify.rows import Rows, rows_of, triangles_of
from pa10d.measurement.encoder_noise import motion_up_to
from pa10d.measurement.signals import Lowpass
from pa10d.model import TorqueModel
from pa10d.regression.layout import Layout
from pa10d.regression.solution import Solution, estimate_weights, solve
from pa10d.regression.steady import FAR, steady_direction
from pa10d.regression.triangle import Triangle

Array = NDArray[np.float64]

ROUNDS = 4
SETTLED_SHARE = 0.1  # standard errors: a step below this is the last
NEAREST = 1e-4  # s of a second look: closer, rounding decides
LEAST_HEARD = 0.2  # of a delay: below that, noise is nearly all that the slope shows
CORRELATED = 6.0  # decimated samples that are worth one independent one, residuals being coloured
SIGNIFICANT = 4.0  # standard errors
LIKELY = 2.0  # standard errors: left out, such a shift costs more than its own doubt does
USUAL = 5e-3  # s: what channels are late by, as a standard deviation before the data
AGREE = 3.0  # standard errors by which slow and fast parts of the motion may differ
BENT = 1.0 / 3.0  # of what a lack bends slow parts by, fast ones may be bent by, too (policy)
LACK_BENDS = 1.0 / 3.0  # of what a model lacks may go as the torque's slope does (policy)
MOST = 0.5  # of the joints
EARLIEST = 2e-3  # s, or a sample: angles that come later than that after the torque are rare, but
# springs and gaps between motor and link look so
EARLY_KNOWN = 0.1  # of itself, to which such a shift has to be known to be taken (policy)
FARTHEST = 0.05  # s: beyond that a joint's shift is rather something that the model lacks (policy)
FARTHEST_TOGETHER = 0.2  # s, where joints agree: a first-order low-pass of 1 Hz is 0.16 s late


@dataclass(frozen=True)
class Shift:
    """seconds: positive where torque is late, 0 where nothing significant was found.

    estimate, std_error: what the joints say together; joints (n,) what each says, s
    slow: what all parts of the motion say together where fast ones say otherwise, else nan
    noise: what noise alone makes of the standard error; errors (n,): of each joint; without
    (stretches,): the estimate from all stretches of the data but one
    """

    seconds: float
    estimate: float
    std_error: float
    joints: Array
    slow: float = np.nan
    noise: float = np.inf
    errors: Array = field(default_factory=lambda: np.empty(0), repr=False)
    without: Array = field(default_factory=lambda: np.empty(0), repr=False)

    def later(self, rest: Shift) -> Shift:
        """With what was found beyond it, by columns that have passed what the torque has."""
        return Shift(
            self.seconds + rest.seconds,
            self.seconds + rest.estimate,
            rest.std_error,
            self.seconds + rest.joints,
            self.seconds + rest.slow,
        )


def find_shift(pieces: Pieces, layout: Layout) -> Shift:
    """What all joints say; where fast parts of the motion say otherwise, what those say."""
    motion = motion_up_to([(r.q, r.rate) for r in pieces.recordings])
    heard = _Heard(pieces, layout, first_model(pieces, layout), min(1.0, motion / pieces.cutoff))
    found = _near_or_far(heard)
    if abs(found.estimate) > SIGNIFICANT * found.std_error:
        fast = _iterated(heard, FAR, _differenced)
        if _differ(found, fast):
            bent = BENT * (found.estimate - fast.estimate)
            error = float(np.hypot(fast.std_error, bent))
            found = replace(fast, slow=found.estimate, std_error=error)
    earliest = -max(EARLIEST, *(1.0 / r.rate for r in pieces.recordings))
    believed = found.estimate >= earliest or found.std_error < EARLY_KNOWN * -found.estimate
    likely = believed and _likely(found)
    return replace(found, seconds=found.estimate if likely else 0.0)


def _likely(found: Shift) -> bool:
    """Is none worse than the estimate, beside what is usual? 23 ± 9 ms are rather no shift."""
    standard_errors = found.estimate / found.std_error / np.hypot(1.0, found.std_error / USUAL)
    return bool(abs(standard_errors) > LIKELY) and _agreed(found)


def _agreed(found: Shift) -> bool:
    """Do more than half of the joints that know it from none say the same, as far as they know? A
    delay of one joint's own, of two, is none of the robot. As far as no joint would be believed by
    itself, at least two have to say so."""
    witness = LIKELY * found.errors < abs(found.estimate)
    says_so = np.abs(found.joints - found.estimate) < AGREE * found.errors
    agree = says_so[witness]
    if abs(found.estimate) >= FARTHEST:
        near = abs(found.estimate) < FARTHEST_TOGETHER
        return near and bool(np.sum(agree) > 1 and np.mean(agree) > MOST)
    return not witness.any() or bool(np.mean(agree) > MOST)


@dataclass(frozen=True)
class _Heard:
    """What all looks have in common; model: of the torque whose slope is looked for; band: part of
    the cut-off that is heard."""

    pieces: Pieces
    layout: Layout
    model: TorqueModel
    band: float

    def rows(self, shift: float, far: float, seen: Callable[[Rows], Rows]) -> list[Rows]:
        """Of some pieces, so shifted: decimated, they are few enough to be kept."""
        found = []
        for some in self.pieces.some():
            piece = some.shifted(shift)
            rows = _with_slope(piece, self.layout, self.model, far)
            found.append(seen(_within(rows, piece, self.band, far)))
        return found

    def left(self, triangles: list[Triangle]) -> Shift:
        """What is left of a shift in these rows."""
        return _shift_left(triangles, self.layout, self.band)


def _near_or_far(heard: _Heard) -> Shift:
    """Friction that builds up over a way bends what is seen near reversals, but most of what a
    short run knows may stand there: the sharper one of two estimates, the far one if they
    differ."""
    near, far = (_iterated(heard, way, least=LIKELY) for way in (0.0, FAR))
    return near if near.std_error < far.std_error and not _drawn(near, far) else far


def _drawn(near: Shift, far: Shift) -> bool:
    """Is the sharper one drawn away from the other? Much of what both hear is the same: what their
    difference may be by chance is less than both their errors together (Hausman, again), and how
    it differs from stretch to stretch."""
    chance = np.sqrt(max(far.noise**2 - near.noise**2, 0.0))
    if len(near.without) == len(far.without):
        chance = max(chance, moved_by_stretches(near.without - far.without))
    return bool(abs(near.estimate - far.estimate) > LIKELY * chance)


def _differ(one: Shift, other: Shift) -> bool:
    doubt = np.hypot(one.std_error, other.std_error)
    return bool(abs(one.estimate - other.estimate) > AGREE * doubt)


def _iterated(
    heard: _Heard,
    far: float,
    seen: Callable[[Rows], Rows] = lambda rows: rows,
    least: float = 0.0,
) -> Shift:
    """The shift that leaves none; far: part of a joint's range that it has come since it turned;
    least: standard errors that make it worth more rounds.

    A shift of several samples is not a first-order change, and the slope of the model's torque has
    noise of its own, its encoders', so that only part of a delay is heard: how much shows by a
    second look, at another shift. What bends it differs from stretch to stretch.
    """

    found = heard.left(triangles_of(heard.rows(0.0, far, seen)))
    if not np.isfinite(found.std_error):
        return found
    aside = min(max(abs(found.estimate), found.std_error, NEAREST), FARTHEST)
    at = -aside if found.estimate < 0.0 else aside
    rows = heard.rows(at, far, seen)
    left = heard.left(triangles_of(rows))
    part = min((found.estimate - left.estimate) / at, 1.0)
    if part < LEAST_HEARD:
        return replace(found, std_error=np.inf)
    for _ in range(ROUNDS):
        total, error = at + left.estimate / part, left.std_error / part
        joints = at + left.joints / part
        step = abs(total - at)
        if abs(total) > FARTHEST_TOGETHER:
            break
        if abs(total) < least * error or step < SETTLED_SHARE * error:
            break
        at = total
        rows = heard.rows(at, far, seen)
        left = heard.left(triangles_of(rows))
    without = at + without_each(rows, lambda some: _estimate(heard.left(some))) / part
    errors = _bent(heard, rows, seen) / part
    doubt = max(error, moved_by_stretches(without), _together(errors))
    return Shift(total, total, doubt, joints, noise=error, errors=errors, without=without)


def _estimate(found: Shift) -> float:
    return found.estimate if np.isfinite(found.std_error) else np.nan


def _white(piece: Piece, band: float, seen: Callable[[Rows], Rows]) -> float:
    """How much larger than its square the squared step of white noise is from one sample to the
    next, behind all filters."""
    run = piece.equation
    noise = np.random.default_rng(0).standard_normal((run.lowpass.samples, 1))
    low = run.lowpass(noise)
    if band < 1.0:
        low = Lowpass(len(low), run.rate, band * run.lowpass.cutoff)(low)
    every = np.ones((len(low), 1), dtype=bool)
    tau = seen(Rows([], low, every, every)).tau
    return float(np.mean(np.diff(tau, axis=0) ** 2) / np.mean(tau**2))


def _bent(heard: _Heard, rows: Sequence[Rows], seen: Callable[[Rows], Rows]) -> Array:
    """(n,) s, standard errors of the joints' shifts if of what the model lacks, all that is left
    over but noise, a part goes as the torque's slope does; inf where a joint knows none. White
    noise steps from sample to sample by as much as it is large, what a model lacks hardly at
    all."""
    triangles, steps_of = triangles_of(rows), triangles_of(map(_differenced, rows))
    white = _white(next(heard.pieces.some()), heard.band, seen)
    indices, solution = _solved(triangles, heard.layout)
    errors = np.full(len(triangles), np.inf)
    for j, (all_of_it, steps) in enumerate(zip(triangles, steps_of, strict=True)):
        beta = np.append(solution.beta[indices[j]], -1.0)
        left = all_of_it.squares(beta) / max(all_of_it.rows, 1)
        noise = steps.squares(beta) / max(steps.rows, 1) / white
        lacks = float(np.clip(1.0 - noise / max(left, 1e-300), 0.0, 1.0))
        sharp = float(np.sum(solution.to_beta[heard.layout.size + j] ** 2))
        if sharp > 0.0:
            bends = CORRELATED / heard.band + LACK_BENDS**2 * lacks * all_of_it.rows
            errors[j] = np.sqrt(sharp * bends)
    return errors


def _together(errors: Array) -> float:
    knows = float(np.sum(1.0 / errors**2))
    return 1.0 / np.sqrt(knows) if knows > 0.0 else np.inf


def _solved(triangles: list[Triangle], layout: Layout) -> tuple[list[Array], Solution]:
    """Unknowns of every joint, its delay the last of them, and their values."""
    n, size = len(triangles), layout.size
    indices = [np.append(i, size + j) for j, i in enumerate(layout.of_joint)]
    none = [Triangle(t.width) for t in triangles]
    sigma = estimate_weights(triangles, none, indices, size + n)
    return indices, solve(triangles, indices, size + n, sigma)


def _with_slope(piece: Piece, layout: Layout, model: TorqueModel, far: float) -> Rows:
    rows = rows_of(piece, layout)
    slope = -piece.equation.lowpass(model.predict(piece.context), 1)
    columns = [np.column_stack([c, slope[:, j]]) for j, c in enumerate(rows.columns)]
    return Rows(columns, rows.tau, piece.keep & _steady(_direction(piece, far)), rows.rest)


def _within(rows: Rows, piece: Piece, band: float, far: float) -> Rows:
    """What a low-pass at this part of the cut-off leaves, clear of reversals by its memory."""
    if band == 1.0:
        return rows
    run = piece.equation
    low = Lowpass(len(rows.tau), run.rate, band * run.lowpass.cutoff)
    columns = [low(c) for c in rows.columns]
    inner = np.zeros(len(rows.tau), dtype=bool)
    inner[low.settle : -low.settle] = True
    keep = rows.keep & _steady(low(_direction(piece, far))) & inner[:, None]
    return Rows(columns, low(rows.tau), keep, rows.rest)


def _differenced(rows: Rows) -> Rows:
    """Each sample less the one before it."""
    return Rows(
        [np.diff(c, axis=0) for c in rows.columns],
        np.diff(rows.tau, axis=0),
        rows.keep[1:] & rows.keep[:-1],
        rows.rest[1:],
    )


def _steady(direction: Array) -> NDArray[np.bool_]:
    """Where a filtered direction says that nothing turned round within the filter's memory."""
    return np.asarray(np.abs(direction) > 0.99)


def _direction(piece: Piece, far: float) -> Array:
    """(M, n) where each joint goes, filtered."""
    c = piece.context
    return piece.equation.lowpass(steady_direction(c.q, c.dq, piece.fast, far))


def _shift_left(triangles: list[Triangle], layout: Layout, band: float) -> Shift:
    size, solution = layout.size, _solved(triangles, layout)[1]
    own = solution.beta[size:]
    variance = CORRELATED / band * np.sum(solution.to_beta[size:] ** 2, axis=1)
    known = (own != 0) & (variance > 0)
    if not known.any():
        return Shift(0.0, 0.0, np.inf, own)
    knows = np.where(known, 1.0 / np.where(known, variance, 1.0), 0.0)
    weight = np.minimum(knows, 3.0 * np.median(knows[known]))  # no joint decides alone
    middle = _weighted_median(own, weight)
    spread = 1.4826 * _weighted_median(np.abs(own - middle), weight)
    count = float(np.sum(weight)) ** 2 / float(np.sum(weight**2))
    error = max(1.0 / np.sqrt(float(np.sum(knows))), spread / np.sqrt(count))
    return Shift(middle, middle, error, own)


def _weighted_median(values: Array, weight: Array) -> float:
    order = np.argsort(values)
    share = np.cumsum(weight[order]) - 0.5 * weight[order]
    return float(np.interp(0.5 * np.sum(weight), share, values[order]))
