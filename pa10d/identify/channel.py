"""What the torque channel has passed: a low-pass common to all joints, as far as motion tells it.

A drive that smooths its torque smears every step of friction behind its reversal and bends what
is fast. Columns that pass the same low-pass fit then what they do not fit without it. A real-time
filter delays, so one is sought only where torque is late, with delays of about as much; what is
left of the delay is refitted beside each. Only samples clear of reversals count: what a joint does
while it sticks is nobody's filter. Noise of the angles in a prediction asks for a softer filter
than there is, and is taken off (a corrected score; Nakamura, Biometrika 77, 1990).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.identify.blocks import Pieces
from pa10d.identify.loads import first_model
from pa10d.identify.rows import Rows, rows_of, triangles_of
from pa10d.identify.smoothing import Smoothing
from pa10d.identify.timing import CORRELATED, SIGNIFICANT, Shift
from pa10d.judgement.encoder import less_noise, once_more
from pa10d.measurement.signals import through_channel
from pa10d.measurement.torque_filter import DELAYS, TorqueFilter
from pa10d.regression.layout import Layout
from pa10d.regression.solution import estimate_weights, solve, spread
from pa10d.regression.triangle import Triangle

Array = NDArray[np.float64]

LEAST_DELAY = 0.02  # periods of the cut-off: a filter that fast bends less than a thousandth of
# what passes
DELAYED = (0.25, 0.5, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0)  # of the delay found, tried of each kind
AGREED = 2.0  # standard errors of all joints but the one that asks most (chosen: see 0195)
CLOSER = 2  # rounds of halving the distance between what was tried


@dataclass(frozen=True)
class FoundChannel:
    """passed: what the torque has; std_error: s, of its delay; infinite at the end of what was
    tried, where one that is later yet may suit better."""

    passed: TorqueFilter
    std_error: float

    @property
    def words(self) -> str:
        """``a low-pass of first order at 20.7 ± 3 Hz``."""
        return self.passed.give_or_take(self.std_error / self.passed.delay)


def find_channel(
    pieces: Pieces, layout: Layout, smoothing: Smoothing, shift: Shift
) -> FoundChannel | None:
    """None where torque is not late, where no low-pass is significant, or where the joints do not
    agree without the one that asks for it most: that one may lack something of its own.

    The speed over which friction turns round bends along with each: a smeared step had rounded it.
    """
    if shift.seconds * pieces.cutoff < LEAST_DELAY or layout.robot.n < 2:
        return None
    stretches = [(rows_of(p, layout, smoothing.found), p.keep, p.equation) for p in pieces.some()]
    plain = [replace(rows, keep=keep) for rows, keep, _ in stretches]
    slopes = [run.lowpass.of_torque(run.raw_tau, 1) for _, _, run in stretches]

    def variance(channel: TorqueFilter | None) -> tuple[Array, Array]:
        seen = (
            _behind(rows, slope, channel, run.rate)
            for rows, slope, (_, _, run) in zip(plain, slopes, stretches, strict=True)
        )
        return _variance(triangles_of(seen), layout)

    left = np.sqrt(variance(None)[0])
    noise = _Noise.of(pieces, layout, left)

    def likelihood(channel: TorqueFilter | None) -> Array:
        own, rows = variance(channel)
        own = less_noise(own, noise.makes(channel))
        return np.asarray(-rows / CORRELATED * np.log(own))

    none = likelihood(None)

    def gain(kind: str, times: float) -> Array:
        return likelihood(_of(kind, times * shift.seconds)) - none

    tried = {kind: {d: gain(kind, d) for d in DELAYED} for kind in DELAYS}
    kind = _as_late(tried)
    known = tried[kind]
    for _ in range(CLOSER):
        for d in between(sorted(known), _best(known)):
            known[d] = gain(kind, d)
    best = _best(known)
    each = known[best]
    if each.sum() < SIGNIFICANT**2 or each.sum() - each.max() < AGREED**2:
        return None
    times, error = _vertex(known, best)
    return FoundChannel(_of(kind, times * shift.seconds), error * shift.seconds)


def _as_late(tried: Mapping[str, Mapping[float, Array]]) -> str:
    """Of the kinds that are hardly told from the best one that which is nearest to being as late as
    torque is: of what is later angles would have to be late as well."""
    most = {kind: float(known[_best(known)].sum()) for kind, known in tried.items()}
    alike = [kind for kind, gain in most.items() if gain > max(most.values()) - AGREED**2]
    return min(alike, key=lambda kind: abs(_best(tried[kind]) - 1.0))


def _vertex(known: Mapping[float, Array], best: float) -> tuple[float, float]:
    """Of the parabola through the best delay and its neighbours, in parts of the one that torque
    has, and its standard error: as far away twice the logarithm of the likelihood is less by one.
    Where its neighbours suit as well, nobody knows.
    """
    tried = sorted(known)
    at = tried.index(best)
    if not 0 < at < len(tried) - 1:
        return best, float(np.inf)
    x = np.array(tried[at - 1 : at + 2])
    before, after = np.diff([float(known[d].sum()) for d in x]) / np.diff(x)
    bend = (after - before) / (x[2] - x[0])  # Newton's divided differences: 0 of three alike
    if not bend < 0.0:
        return best, float(np.inf)
    slope = before + bend * (best - x[0])
    return float(best - 0.5 * slope / bend), float(1.0 / np.sqrt(-bend))


def _of(kind: str, delay: float) -> TorqueFilter:
    return TorqueFilter(kind, delay / DELAYS[kind])


def _best(known: Mapping[float, Array]) -> float:
    return max(known, key=lambda d: float(known[d].sum()))


def between(tried: Sequence[float], best: float) -> list[float]:
    """Of rising values: halfway from one of them to either neighbour."""
    at = tried.index(best)
    neighbours = [*tried[max(at - 1, 0) : at], *tried[at + 1 : at + 2]]
    return [0.5 * (best + other) for other in neighbours]


def _behind(rows: Rows, slope: Array, channel: TorqueFilter | None, rate: float) -> Rows:
    """The columns behind the channel, and the delay's beside them."""
    columns = [
        np.column_stack([through_channel(c, channel, rate), -slope[:, j]])
        for j, c in enumerate(rows.columns)
    ]
    return replace(rows, columns=columns)


def _variance(triangles: list[Triangle], layout: Layout) -> tuple[Array, Array]:
    """(n,) (N·m)² of what each joint's rows leave, and (n,) rows."""
    size, indices = layout.size, []
    for t, own in zip(triangles, layout.of_joint, strict=True):  # last of a row is the torque
        more = t.width - 1 - len(own)
        indices.append(np.append(own, np.arange(size, size + more)))
        size += more
    none = [Triangle(t.width) for t in triangles]
    sigma = estimate_weights(triangles, none, indices, size)
    beta = solve(triangles, indices, size, sigma).beta
    left = spread(triangles, none, indices, beta)
    return np.asarray(left**2), np.array([float(t.rows) for t in triangles])


@dataclass(frozen=True)
class _Noise:
    """What noise of the angles makes of a prediction: the softer a channel, the less, whether that
    is the channel or not. parts: per piece what (M, n) is once more of it, several draws, which
    samples count (M, n), and the rate in Hz."""

    parts: list[tuple[list[Array], NDArray[np.bool_], float]]

    @classmethod
    def of(cls, pieces: Pieces, layout: Layout, left: Array) -> _Noise:
        """left: (n,) N·m RMS of the fit, of which it may be too little to matter."""
        model, parts = first_model(pieces, layout), []
        for piece in pieces.some():
            seen, run = model.contextualise(piece.context), piece.equation
            draws = [run.lowpass(one) for one in once_more(model, seen, run, left)]
            parts.append((draws, piece.keep, run.rate))
        return cls(parts)

    def makes(self, channel: TorqueFilter | None) -> Array:
        """(n,) (N·m)², mean over the samples that count."""
        squares, counts = 0.0, np.zeros(self.parts[0][1].shape[1])
        for draws, keep, rate in self.parts:
            for one in draws:
                squares = squares + np.sum(through_channel(one, channel, rate) ** 2 * keep, axis=0)
            counts += len(draws) * keep.sum(axis=0)
        return np.asarray(squares / np.maximum(counts, 1.0)) + np.zeros(len(counts))
