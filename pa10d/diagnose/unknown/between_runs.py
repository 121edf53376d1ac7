"""Fitted runs that contradict each other: one asks for parameters that another refuses.

A payload that was there on one day, friction that rose, a sensor that was zeroed anew: a model of
all runs is right in none, and what it leaves looks like whatever it happens to look like. So what
may have changed is tried in some of the runs alone (Chow 1960: other coefficients in a part of the
data), under noise as slow as it is, and has to hold from one stretch of time to the next; and no
law of the motion may take as much, for runs that go elsewhere meet another part of it. What an arm
picks up or puts down on its way contradicts itself within a run; that is tried likewise, and
believed where no place and no direction of the motion tells the two sides apart as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.words import listed
from pa10d.diagnose.constants import (
    BROKEN_SHARE,
    CLAIMED_SHARE,
    COMING_ON,
    CONTRADICTED_LEVEL,
    MATERIAL_GAIN,
    MATERIAL_REST,
    PICKED_MOMENTS,
    STEP_CLOSELY,
    STEP_MARGIN,
)
from pa10d.diagnose.evidence.held_out import fit_side_power
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState, Suspects
from pa10d.diagnose.unknown.own_part import OwnPart, beside, lasting, own_part
from pa10d.diagnose.unknown.parts import ByAndBy, InPart, InPlace, seconds_of
from pa10d.diagnose.unknown.structure import strongest_maps
from pa10d.effects import Effect, Shape
from pa10d.effects.base import Value
from pa10d.model import Term
from pa10d.model.term import as_told

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Apart:
    """Of a joint (0-based): runs ask for something of which the others have none, or less.

    share: of the squared error that a fit leaves there, which is gone if they may have it; rms:
    N·m of that; p_value: of all that was tried; effects: as people call them; at: s since these
    runs began, where it came or went on the way; came: what did, and by how much, where one effect
    did and the data tell
    """

    joint: int
    share: float
    rms: float
    p_value: float
    runs: tuple[str, ...]
    others: tuple[str, ...]
    effects: tuple[str, ...]
    variables: tuple[str, ...] = ()
    held_out: bool = False  # it is the held-out runs that ask for it
    at: float | None = None
    came: str = ""

    @property
    def all_along(self) -> bool:
        """Would it do to have it in all runs? The fitted ones alone then do not show it."""
        return not self.runs

    @property
    def who(self) -> str:
        """What contradicts what, as the subject and verb of a sentence."""
        if self.all_along:
            return "the fitted runs alone do not show what those held out ask for"
        if self.held_out:
            return "the runs held out contradict the fitted ones"
        if self.at is not None:
            return "the arm is another one from one moment on"
        return "the fitted runs contradict each other"

    @property
    def words(self) -> str:
        """``as if Coulomb friction came or went between mon and tue``."""
        if self.all_along:
            return f"as if {listed(self.effects)} were there in all of them"
        if self.at is not None:
            moment = f"{self.at:.1f} s into {listed(self.runs)}"
            return f"as if {self.came or f'{listed(self.effects)} came or went'} {moment}"
        between = f"{listed(self.others)} and {listed(self.runs)}"
        return f"as if {listed(self.effects)} came or went between {between}"


@dataclass(frozen=True)
class Contradiction:
    """told: a line for each joint concerned; left (n,) N·m RMS that the fit leaves, if runs may
    differ in that."""

    told: tuple[Apart, ...]
    left: Array


@dataclass(frozen=True)
class _Own(OwnPart):
    """An effect that a part of the samples has for itself."""

    effect: Effect
    joints: tuple[int, ...]
    part: InPart | InPlace | ByAndBy

    @property
    def runs(self) -> tuple[str, ...]:
        return self.part.runs


def unlike_fitted(
    state: SearchState, given: int, suspects: Suspects, floor: Array
) -> tuple[Apart, ...]:
    """What the held-out runs ask for that the fitted ones refuse, where they leave more: a fit to
    all of them, with all findings, is asked as fitted runs are. Nothing where runs are on both
    sides. given: terms that the model had before any finding"""
    held = tuple(dict.fromkeys(run.name for run in state.held.runs))
    fitted = {run.name for run in state.train.runs}
    worse = _left_of_held(state) > MATERIAL_REST * np.maximum(state.fit.rms(), np.nan_to_num(floor))
    if state.frozen or fitted & {*held} or not worse.any():
        return ()
    told = contradiction(_fitted_to_all(state, given), suspects, floor, [held]).told
    # more than all that the fitted runs leave by themselves, slow noise of theirs among it
    least = np.where(worse, MATERIAL_REST * state.fit.rms(), np.inf)
    return tuple(replace(one, held_out=True) for one in told if one.rms > least[one.joint])


def contradiction(
    state: SearchState,
    suspects: Suspects,
    floor: Array,
    parts: Sequence[tuple[str, ...]] | None = None,
) -> Contradiction:
    """What runs of the fit side ask for by themselves, on joints that keep more than noise; and
    what came or went within them, whatever the noise floor is: where a motion comes again, all that
    is picked up between its passes is in that.

    suspects: what may change; floor: (n,) N·m; nan where it is not known: what changed has to stand
    out from slow noise anyway; parts: the names of runs that may (None: any)
    """
    fit, least = state.fit, MATERIAL_REST * np.nan_to_num(floor)
    names = tuple(dict.fromkeys(run.name for run in state.train.runs))
    taken: list[tuple[_Own, float]] = []
    came: list[str] = []
    concerned = fit.rms() > least
    groups = [InPart(runs) for runs in (_parts(names) if parts is None else parts)]
    moments = list(_moments(state.train, names)) if parts is None else []
    # a model that is fitted anew has taken up what was there all along; one that stays has not
    throughout = [InPart(())] if moments and state.frozen else []
    while len(taken) < state.train.n:
        keeps = fit.rms() > least
        on_the_way = [(e, j) for e, j in suspects if e.picked_up and (not j or keeps[[*j]].any())]
        tried, count = _best_of_each(_tried(state, on_the_way, fit, [*moments, *throughout]))
        if groups and np.any(keeps):
            between = list(_tried(state, suspects, fit, [*groups, InPart(())]))
            tried, count = [*tried, *between], count + len(between)
        best = _plainest([one for one in tried if one.runs])
        if best is None:
            break
        best, lasts = _to_the_moment(state, fit, best, [one for one, _ in taken])
        always = _all_along(tried, best)
        if always is not None and parts is None:
            break
        if always is not None:
            best, lasts = always, lasting(state.train, fit, always)
        p_value = _chance(state.train, fit, best) * count
        if p_value > CONTRADICTED_LEVEL or not lasts:
            break
        at = best.part.at
        if at is not None and (_told_by_place(state, fit, best, at) or _slowly(state, fit, best)):
            moments = []
            continue
        if parts is None and best.part.at is None and _told_by_motion(state, best):
            break
        taken.append((best, p_value))
        came.append(_came(state, fit, best))
        fit = beside(fit, best)
    if any(one.part.at is not None for one, _ in taken):
        concerned[:] = True
    told = _told(taken, came, names, concerned, state.fit, fit) if taken else ()
    return Contradiction(tuple(told), fit.rms())


def _fitted_to_all(state: SearchState, given: int) -> SearchState:
    """The same with all its findings, fitted to what is held out as well."""
    side = Side.of([*state.train.runs, *state.held.runs])
    whole = SearchState.start(
        state.model, side, state.held, state.frozen, none_at_least=state.none_at_least
    )
    for index, term in enumerate(state.terms):
        if index < given:
            whole.replace_term(index, term)
        else:
            whole.push(term)
    whole.refit()
    return whole


def _left_of_held(state: SearchState) -> Array:
    """(n,) N·m RMS; nothing of a joint of which no sample counts."""
    left = state.held_residual()
    return np.array([_rms(left[j]) for j in range(state.held.n)])


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def needless(state: SearchState, suspects: Suspects, fixed: int, floor: Array) -> SearchState:
    """The state without findings that runs which contradict each other can do without: what they
    ask for by themselves leaves no more than with the finding (0070, rule 15)."""
    if len(state.terms) == fixed or not contradiction(state.bare(fixed), suspects, floor).told:
        return state
    for index in reversed(range(fixed, len(state.terms))):
        rest, joints = state.copy(), list(state.terms[index].joints) or slice(None)
        rest.drop(index)
        rest.refit()
        alone = contradiction(rest, suspects, floor)
        kept = contradiction(state, suspects, floor)
        if alone.told and np.all(alone.left[joints] <= (1.0 + MATERIAL_GAIN) * kept.left[joints]):
            state = rest
    return state


def _told_by_place(state: SearchState, fit: LeastSquares, best: _Own, at: float) -> bool:
    """Would a place or a direction of the motion do as well as that moment? An arm that is not
    where it was need not have changed: what a model lacks may act there alone."""
    n, sides = state.train.n, (False, True)
    places = [InPlace(best.runs, *one) for one in product(range(n), [at], sides, sides)]
    found = _tried(state, [(best.effect, best.joints)], fit, places)
    return max((one.gain for one in found), default=0.0) > (1.0 - MATERIAL_GAIN) * best.gain


def _slowly(state: SearchState, fit: LeastSquares, best: _Own) -> bool:
    """Would it do as well to come on by and by, as what warms does?"""
    longest = _longest(state.train, best.runs[0])
    slow = [ByAndBy(best.runs, longest * part) for part in COMING_ON]
    found = _tried(state, [(best.effect, best.joints)], fit, slow)
    return max((one.gain for one in found), default=0.0) > (1.0 - MATERIAL_GAIN) * best.gain


def _came(state: SearchState, fit: LeastSquares, own: _Own) -> str:
    """``Coulomb friction rose by 2.5 ± 0.1 N·m``, ``a payload of 1.4 ± 0.1 kg came``: what a moment
    brought, or took away; nothing where the data leave some of it open, or there was none."""
    part, kind = own.part, own.effect
    if not isinstance(part, InPart) or part.at is None or own.size < len(own.theta):
        return ""
    power = fit_side_power(state.train, fit.residual, own.change)
    covariance = own.free @ own.free.T * own.gain / max(power, 1e-300)
    shape = dict(_shape(state, kind, own.joints))
    values = kind.values(own.theta, covariance, shape, {})
    term = Term(kind.id, own.joints, own.theta, shape)
    size = next(iter(as_told(state.model.robot, term, values).values()))
    return _brought(kind, size, part.before) if size.determined else ""


def _brought(kind: Effect, size: Value, before: bool) -> str:
    """before: the part before the moment has it. What cannot be less than nothing went where the
    model had it and a part has less: a load that was put down."""
    if kind.coefficients[0].lower < 0.0:
        return f"{kind.named} of {size} {'went' if before else 'came'}"
    more = (size.value > 0.0) != before
    if kind.rubs:
        return f"{kind.named} {'rose' if more else 'fell'} by {abs(size)}"
    return f"{kind.named} of {abs(size)} {'came' if more else 'went'}"


def _told_by_motion(state: SearchState, best: _Own) -> bool:
    """Does one law of the motion take as much, and foretell most of what runs held out keep where
    the fitted ones have been? Runs that go elsewhere meet another part of what a model lacks, and
    ask for other parameters though nothing changed."""
    power = {j: float(moved @ moved) for j, moved in best.change.items()}
    joint = max(power, key=lambda j: power[j])
    if joint in state.held.silent:
        return False
    left, held = state.fit.residual[joint], state.held_residual()[joint]
    taken = float(left @ left) - float(np.sum((left - best.change[joint]) ** 2))
    for law in strongest_maps(state, joint):
        r, inside = held[law.inside], law.values[law.inside]
        foretold = 1.0 - float(np.sum((r - inside) ** 2)) / max(float(r @ r), 1e-300)
        gain = 0.0 if law.map is None else law.map.gain
        if gain > (1.0 - MATERIAL_GAIN) * taken and foretold > BROKEN_SHARE:
            return True
    return False


def _tried(
    state: SearchState,
    suspects: Suspects,
    fit: LeastSquares,
    parts: Sequence[InPart | InPlace | ByAndBy],
) -> Iterator[_Own]:
    """Each that may have changed, in each of these parts of the samples."""
    side = state.train
    seconds = [seconds_of(side, j) for j in range(side.n)]
    for effect, joints in suspects if parts else ():
        if not all(s.smoothing or s.optional for s in effect.shapes):
            continue  # what has a shape of its own bends to what a model lacks
        columns = side.columns(effect, joints, [_shape(state, effect, joints)])
        weighted = {j: c / fit.sigma[j] for j, c in columns.items()}
        for part in parts:
            own = own_part(
                fit, {j: c * part.rows(side, j, seconds[j])[:, None] for j, c in weighted.items()}
            )
            if own is not None:
                yield _Own(**vars(own), effect=effect, joints=joints, part=part)


def _best_of_each(found: Iterator[_Own]) -> tuple[list[_Own], int]:
    """Of each effect and each set of runs the moment that takes most, and how many were tried."""
    best: dict[tuple[str, tuple[int, ...], tuple[str, ...]], _Own] = {}
    count = 0
    for one in found:
        count += 1
        place = one.effect.id, one.joints, one.runs
        if place not in best or one.gain > best[place].gain:
            best[place] = one
    return list(best.values()), count


def _moments(side: Side, names: Sequence[str]) -> Iterator[InPart]:
    """Before and after some moments of one run alone, and after those that all runs have."""
    last = {name: _longest(side, name) - STEP_MARGIN for name in names}
    for name in names:
        for at in _between(last[name]):
            yield from (InPart((name,), at, before) for before in (False, True))
    if len(names) > 1:
        yield from (InPart(tuple(names), at) for at in _between(min(last.values())))


def _between(last: float) -> list[float]:
    """s, evenly from the first to the last at which both sides can be told."""
    if last <= STEP_MARGIN:
        return []
    return np.linspace(STEP_MARGIN, last, PICKED_MOMENTS).tolist()


def _longest(side: Side, name: str) -> float:
    """s that the longest stretch of a run takes."""
    lasts = zip(side.runs, side.contexts, strict=True)
    return max(float(context.t[-1] - context.t[0]) for run, context in lasts if run.name == name)


def _to_the_moment(
    state: SearchState, fit: LeastSquares, best: _Own, taken: Sequence[_Own]
) -> tuple[_Own, bool]:
    """``_closely``, and does it last? A run of which blocks of time are held out is asked as a
    whole: the moment may lie in one of those, where the fit side knows of none better than of
    another, and half a run has few stretches in which something lasts."""
    part = best.part
    if not isinstance(part, InPart) or part.at is None:
        return best, lasting(state.train, fit, best)
    if not {run.name for run in state.held.runs} & {*part.runs}:
        best = _closely(state, fit, best)
        return best, lasting(state.train, fit, best)
    whole = _fitted_to_all(state, len(state.model.terms))
    of_all = whole.fit
    for one in taken:
        again = _anew(whole, of_all, one)
        of_all = of_all if again is None else beside(of_all, again)
    last = min(_longest(state.train, name) for name in part.runs) - STEP_MARGIN
    parts = [replace(part, at=at) for at in _between(last)]
    tried = list(_tried(whole, [(best.effect, best.joints)], of_all, parts))
    if not tried:
        return best, False
    found = _closely(whole, of_all, max(tried, key=lambda one: one.gain))
    return _anew(state, fit, found) or best, lasting(whole.train, of_all, found)


def _anew(state: SearchState, fit: LeastSquares, one: _Own) -> _Own | None:
    """The same of another fit."""
    return next(_tried(state, [(one.effect, one.joints)], fit, [one.part]), None)


def _closely(state: SearchState, fit: LeastSquares, best: _Own) -> _Own:
    """The same with the moment that suits best, sought ever more closely about it."""
    part = best.part
    if not isinstance(part, InPart) or part.at is None:
        return best
    longest = _longest(state.train, part.runs[0])
    last, apart = max(longest - STEP_MARGIN, STEP_MARGIN), longest / (PICKED_MOMENTS - 1)
    while apart > STEP_CLOSELY:
        near = (best.part.at or part.at) + apart * np.linspace(-1.0, 1.0, 9)
        near = np.clip(near, STEP_MARGIN, last)
        parts = [replace(part, at=float(at)) for at in near]
        found = _tried(state, [(best.effect, best.joints)], fit, parts)
        best, apart = max([best, *found], key=lambda one: one.gain), apart / 4.0
    return best


def _parts(names: Sequence[str]) -> list[tuple[str, ...]]:
    """Each run by itself, and all from one on; of two halves one says it all."""
    if len(names) < 2:
        return []
    one = [(name,) for name in names[1:]] if len(names) == 2 else [(name,) for name in names]
    since = [tuple(names[k:]) for k in range(2, len(names) - 1)]
    return [*one, *since]


def _shape(state: SearchState, effect: Effect, joints: tuple[int, ...]) -> Shape:
    there = [t for t in state.terms if (t.effect_id, t.joints) == (effect.id, joints)]
    return there[0].shape if there else effect.starts(state.train.contexts[0], joints)[0]


def _all_along(tried: Sequence[_Own], best: _Own) -> _Own | None:
    """What would do as well where it is in all runs: then nothing came or went, and some of them
    alone do not tell it from what the model has in its place."""
    always = [one for one in tried if not one.runs]
    most = max(always, key=lambda one: one.gain, default=None)
    return None if most is None or most.gain <= (1.0 - MATERIAL_GAIN) * best.gain else most


def _plainest(tried: Sequence[_Own]) -> _Own | None:
    """Of those that take as much as any the one that spends least on it."""
    most = max((one.gain for one in tried), default=0.0)
    near = [one for one in tried if one.gain > (1.0 - MATERIAL_GAIN) * most]

    def spends(one: _Own) -> tuple[float, ...]:
        return one.size, one.part.at is not None, len(one.runs), -one.gain

    return min(near, key=spends, default=None)


def _chance(side: Side, fit: LeastSquares, own: _Own) -> float:
    return float(scipy.stats.chi2.sf(fit_side_power(side, fit.residual, own.change), own.size))


def _told(
    taken: Sequence[tuple[_Own, float]],
    came: Sequence[str],
    names: Sequence[str],
    concerned: NDArray[np.bool_],
    before: LeastSquares,
    after: LeastSquares,
) -> Iterator[Apart]:
    """A line for each joint of which enough is gone."""
    for j in np.flatnonzero(concerned & (before.rms() > 0.0)).tolist():
        had, left = before.rms()[j], after.rms()[j]
        share = 1.0 - (left / had) ** 2
        if share < BROKEN_SHARE:
            continue
        power = [float(one.change[j] @ one.change[j]) for one, _ in taken]
        most, p_value = taken[int(np.argmax(power))]
        mine = [
            one for (one, _), p in zip(taken, power, strict=True) if p > CLAIMED_SHARE * sum(power)
        ]
        yield Apart(
            joint=j,
            share=float(share),
            rms=float(np.sqrt(share) * had),
            p_value=p_value,
            runs=most.runs,
            others=tuple(name for name in names if name not in most.runs),
            effects=tuple(dict.fromkeys(one.effect.named for one in mine)),
            at=most.part.at,
            came=came[int(np.argmax(power))] if len(mine) == 1 else "",
        )
