"""What the torque channel has passed, asked once more beside all that was found.

Identification asks it of the textbook model (0195), and what that lacks may hide it: joints
contradict each other in how late they are, and a low-pass goes for a delay. It smears each step of
friction behind its reversal then, and bristles stand in for that. Noise of the angles asks for a
softer channel than there is, and is taken off.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import CHANNEL_STEP
from pa10d.diagnose.evidence.held_out import quadratic_form
from pa10d.diagnose.regression.behind import moved_by, torque_of
from pa10d.diagnose.regression.clear_of_knocks import clear_of_knocks
from pa10d.diagnose.regression.partial import solve_symmetric
from pa10d.diagnose.regression.shaken import made_held_out, shaken
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.shape_slopes import beyond, shape_slopes
from pa10d.diagnose.search.timing import sizes
from pa10d.identify.channel import AGREED, CLOSER, DELAYED, LEAST_DELAY, between
from pa10d.identify.timing import SIGNIFICANT
from pa10d.measurement.torque_filter import DELAYS, TorqueFilter
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]
Gains = tuple[Array, Array]
Asks = Callable[[TorqueFilter], Gains]


def behind_channel(state: SearchState) -> SearchState | None:
    """The same behind the low-pass that suits all joints best, all shapes as they are, asked clear
    of knocks; None where torque is not late, where none is significant beside what is known of it,
    where all joints but the one that asks most would not ask for it, or where motion held out is no
    better told with it. One that identification saw has to show beside what was found, too; and
    none takes its place that is farther from being as late as torque is: what a law is off by asks
    for smoothness, and that angles are late as well is a claim of its own."""
    first = state.train.runs[0]
    late = first.shift * first.lowpass.cutoff
    if state.frozen or late < LEAST_DELAY or state.train.n < 2:
        return None
    (seen,) = clear_of_knocks(state)
    asks = _asking(seen, {})
    each = [_of_kind(k, first.shift / late, asks) for k, late in DELAYS.items()]
    to, gains = _as_late(seen, each)
    now = first.lowpass.channel
    if now is None:
        tried = [to] if _agreed(*gains) else []
    else:
        tried = [] if _agreed(*_asking(seen.behind(None), {})(to)) else [None]
        off = abs(now.delay - first.shift)
        nearer = [one for one in each if abs(one[0].delay - first.shift) <= off]
        if nearer:
            to, gains = _as_late(seen, nearer)
            tried += [to] if to != now and _over(*gains) > AGREED else []  # but for chance
    better = (one for one in tried if _better(seen, seen.behind(one)))
    return next((state.behind(one) for one in better), None)


def beside_springs(state: SearchState) -> SearchState | None:
    """The same behind the low-pass that suits all joints best together, where a joint with a spring
    does not ask for it as it is: that was fitted without it, and has taken its part, so that it has
    to be fitted with it first (``agree_by_now``)."""
    first = state.train.runs[0]
    late = first.shift * first.lowpass.cutoff
    sprung = any(term.effect.series_spring for term in state.terms)
    if not sprung or state.frozen or late < LEAST_DELAY or first.lowpass.channel is not None:
        return None
    (seen,) = clear_of_knocks(state)
    asks = _asking(seen, shape_slopes(seen))
    each = [_of_kind(k, first.shift / late, asks) for k, late in DELAYS.items()]
    to, gains = _as_late(seen, each)
    return state.behind(to) if _over(*gains) > SIGNIFICANT else None


def agree_by_now(before: SearchState, after: SearchState) -> bool:
    """Do all joints together, and all but the one that gains most, gain by as much as they would
    have to ask for: now that both states are as good as they get?"""
    was, now = clear_of_knocks(before, after)
    left, sigma = now.train_residual(), was.fit.sigma
    rest = {j: r / sigma[j] for j, r in left.items()}
    own = {j: was.fit.residual[j] - r for j, r in rest.items()}
    gains = np.array([own[j] @ (was.fit.residual[j] + rest[j]) for j in sorted(own)])
    errors = 2.0 * np.sqrt(np.maximum(_variance(was, own, rest), 0.0))
    return _agreed(gains, errors)


def _better(before: SearchState, after: SearchState) -> bool:
    """Is motion held out told better, without reversals and with them?"""
    was, now = (sizes(one, made_held_out(one)).sum(axis=1) for one in (before, after))
    return bool(np.all(now < was))


def _as_late(
    state: SearchState, each: list[tuple[TorqueFilter, Gains]]
) -> tuple[TorqueFilter, Gains]:
    """Of the best of each kind, and of those that are hardly told from it, the one that is nearest
    to being as late as torque is: of what is later angles would have to be late as well."""
    best = max(each, key=lambda one: float(one[1][0].sum()))
    late = state.train.runs[0].shift
    sooner = [one for one in each if abs(one[0].delay - late) < abs(best[0].delay - late)]
    if not sooner:
        return best
    asks = _asking(state.behind(best[0]), {})
    alike = [one for one in sooner if _over(*asks(one[0])) > -AGREED]
    return min([best, *alike], key=lambda one: abs(one[0].delay - late))


def tuned(state: SearchState) -> SearchState:
    """The same behind such a channel as suits best, clear of knocks, with shapes anew beside it:
    they were settled beside another one, or none, and each would follow the other. The state itself
    where the channel stays."""
    now = state.train.runs[0].lowpass.channel
    if now is None:
        return state
    (seen,) = clear_of_knocks(state)
    channel, _ = _of_kind(now.kind, now.seconds, _asking(seen, shape_slopes(seen)))
    return state if channel == now else state.behind(channel)


def channel_words(state: SearchState) -> str:
    """``a low-pass of first order at 20.7 ± 3 Hz``, with its error under the noise that is left
    clear of knocks, shapes free, or as joints contradict each other, what that makes more; nothing
    where there is none."""
    now = state.train.runs[0].lowpass.channel
    if now is None:
        return ""
    (seen,) = clear_of_knocks(state)
    other = replace(now, seconds=(1.0 + CHANNEL_STEP) * now.seconds)
    changed = moved_by(seen, torque_of(seen), other, now)
    own = _beyond(seen, changed, shape_slopes(seen))
    made = _made_of(seen, other, now)
    power = sum(float(o @ o) for o in own.values())
    noise = _variance(seen, own, seen.fit.residual)
    apart = [(float(own[j] @ seen.fit.residual[j]) + made[j]) ** 2 for j in own]
    variance = max(sum(noise), sum(apart) * len(apart) / (len(apart) - 1))
    return now.give_or_take(CHANNEL_STEP * float(np.sqrt(variance)) / max(power, 1e-300))


def _made_of(state: SearchState, other: TorqueFilter, now: TorqueFilter) -> Array:
    """(n,) of what is left against the step from one channel to the other: what noise of the angles
    takes off, which both have."""
    noise, sigma = shaken(state, state.train), state.fit.sigma
    here, there = noise.behind(now), noise.behind(other)
    each = [
        [float(h[j][:, 0] @ (t[j] - h[j])[:, 0]) / sigma[j] ** 2 for j in range(len(sigma))]
        for h, t in zip(here, there, strict=True)
    ]
    return np.mean(each, axis=0) if each else np.zeros(len(sigma))


def _of_kind(kind: str, seconds: float, asks: Asks) -> tuple[TorqueFilter, Gains]:
    """The filter of a kind, of about so many seconds, with the largest gain of all joints."""

    def tried(parts: Iterable[float]) -> dict[float, Gains]:
        return {p: asks(TorqueFilter(kind, p * seconds)) for p in parts}

    def most() -> float:
        return max(known, key=lambda part: float(known[part][0].sum()))

    known = tried(DELAYED)
    for _ in range(CLOSER):
        known |= tried(between(sorted(known), most()))
    return TorqueFilter(kind, most() * seconds), known[most()]


def _agreed(gains: Array, errors: Array) -> bool:
    """Do all joints together ask for it, and all but the one that asks most? By as much as a
    parameter of so many standard errors: the gain g of what is there has the error 2·√g."""
    others = np.ones(len(gains))
    others[np.argmax(gains)] = 0.0
    return _over(gains, errors) > SIGNIFICANT and _over(others * gains, others * errors) > AGREED


def _over(gains: Array, errors: Array) -> float:
    return 2.0 * float(gains.sum() / max(float(np.sqrt(np.sum(errors**2))), 1e-300))


def _asking(state: SearchState, slopes: PerJoint) -> Asks:
    """By channel: (n,) what each joint's squared weighted error falls by behind it, less what noise
    of the angles makes of that, coefficients anew and shapes along their ``slopes`` (m_j, s), and
    (n,) the standard error that the noise which is left gives it."""
    fit, n = state.fit, state.train.n
    torque, now = torque_of(state), state.train.runs[0].lowpass.channel
    noise = shaken(state, state.train)
    made = noise.squares(now)

    def asks(channel: TorqueFilter) -> Gains:
        own = _beyond(state, moved_by(state, torque, channel, now), slopes)
        gains = np.array([2.0 * own[j] @ fit.residual[j] - own[j] @ own[j] for j in range(n)])
        gains += (noise.squares(channel) - made) / fit.sigma**2
        errors = _variance(state, own, {j: fit.residual[j] - own[j] for j in range(n)})
        return gains, 2.0 * np.sqrt(np.maximum(errors, 0.0))

    return asks


def _beyond(state: SearchState, moved: PerJoint, slopes: PerJoint) -> PerJoint:
    """joint -> (m_j,) weighted: of what moves, joint -> (m_j, 1), what neither coefficients absorb
    nor shapes along ``slopes``."""
    left = {j: c[:, 0] for j, c in beyond(state.fit.basis, moved).items()}
    if not slopes:
        return left
    gram = np.sum([s.T @ s for s in slopes.values()], axis=0)
    along = solve_symmetric(gram, np.sum([slopes[j].T @ c for j, c in left.items()], axis=0))
    return {j: c - slopes[j] @ along for j, c in left.items()}


def _variance(state: SearchState, own: PerJoint, noise: PerJoint) -> list[float]:
    """(n,) of the projections of the noise on weighted rows (m_j,), by its own spectrum."""
    train = state.train
    moves, left = train.scatter(own), train.scatter(noise)
    return [
        sum(
            quadratic_form(m[:, j], e[:, j], k[:, j], run.rate)
            for m, e, k, run in zip(moves, left, train.keep, train.runs, strict=True)
        )
        for j in range(train.n)
    ]
