"""Every effect on every joint that may be missing, each with its best shape on the fit side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.parallel import shared_map
from pa10d.diagnose.constants import (
    ABSORBED,
    CLOSER_LOOKS,
    SEARCH_THREADS,
    START_THIN,
    TOGETHER,
    WORTH_JUDGING,
)
from pa10d.diagnose.regression.partial import PartialFit, partials
from pa10d.diagnose.regression.shapes import around, refine
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.ripple import order_peaks, shaken_orders
from pa10d.effects import Context, Effect, Shape
from pa10d.model import Term
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Candidate:
    """An effect on its joints with the shape that the fit side likes best."""

    effect: Effect
    joints: tuple[int, ...]
    shape: dict[str, float]
    partial: PartialFit

    @property
    def gain(self) -> float:
        """Weighted squared error that it removes from the fit side."""
        return self.partial.gain

    @property
    def term(self) -> Term:
        """As a term of a model."""
        return Term(self.effect.id, self.joints, self.partial.theta, dict(self.shape))


Best = tuple[dict[str, float], PartialFit]
"""A shape and what it adds."""


def scan(
    state: SearchState,
    pairs: Sequence[tuple[Effect, tuple[int, ...]]],
    tick: Callable[[float], None] = lambda share: None,
) -> list[Candidate]:
    """Best starting shape of every suspect, strongest first; of suspects that come in variants
    (a bump or a wave, warmed by time or by its own heat) of each that the fit side does not speak
    clearly against: which one holds is for the held-out side to say."""
    _prepare(state, [effect for effect, _ in pairs])
    tried = shared_map(lambda pair: _best_starts(state, *pair), pairs, tick)
    found = [
        Candidate(effect, joints, *best)
        for (effect, joints), variants in zip(pairs, tried, strict=True)
        for best in variants
    ]
    return sorted(found, key=lambda c: -c.gain)


def sharpened(state: SearchState, candidates: Sequence[Candidate]) -> list[Candidate]:
    """The same candidates with their shapes refined on the fit side, strongest first."""
    refined = shared_map(lambda c: _refined(state, c), candidates)
    found = [
        replace(candidate, shape=shape, partial=partial)
        for candidate, (shape, partial) in zip(candidates, refined, strict=True)
    ]
    return sorted(found, key=lambda c: -c.gain)


def started(
    state: SearchState, effect: Effect, joints: tuple[int, ...], least: float = ABSORBED
) -> list[Candidate]:
    """Every shape that the search of one effect begins with, as far as the fit side can tell it;
    least: share of a column's power that the model has to leave."""
    found = _tried(state, effect, joints, _starts(state, effect, joints), False, least)
    return [Candidate(effect, joints, *one) for one in found]


def absorbed(state: SearchState, pairs: Sequence[tuple[Effect, tuple[int, ...]]]) -> bool:
    """Is there no shape of any of these, of all that a search begins with, which the fit side can
    tell from what the model has?"""
    shapes = [(effect, joints, _starts(state, effect, joints)) for effect, joints in pairs]
    begun = [one for one in shapes if one[2]]
    return bool(begun) and not any(_tried(state, *one, own=False) for one in begun)


def _prepare(state: SearchState, effects: Iterable[Effect]) -> None:
    """What many suspects look at, before two processes would compute it each for themselves."""
    if any(e.uses_model and e.reaches_other_joints for e in effects):
        # compiled code that leaves the interpreter
        with ThreadPoolExecutor(SEARCH_THREADS) as pool:
            list(pool.map(lambda context: context.sensitivity(0), state.train.contexts))


def _refined(state: SearchState, candidate: Candidate) -> Best:
    if state.same_before(candidate.effect, candidate.joints) is not None:
        return candidate.shape, candidate.partial
    known: dict[tuple[float, ...], PartialFit] = {}
    kind, falls = candidate.effect, state.may_fall(candidate.effect)

    def partial_of(shape: dict[str, float]) -> PartialFit:
        key = tuple(shape.values())
        if key not in known:
            columns = state.train.columns(kind, candidate.joints, [shape])
            known[key] = partials(state.fit, columns, kind, len(kind.coefficients), falls=falls)[0]
        return known[key]

    shape = refine(kind, candidate.shape, lambda s: partial_of(s).gain)
    return shape, partial_of(shape)


def held_columns(state: SearchState, candidate: Candidate) -> PerJoint:
    """Columns of a candidate on the held-out side."""
    return state.held.columns(candidate.effect, candidate.joints, [candidate.shape])


def all_motion(contexts: Sequence[Context]) -> Context:
    """Every run's motion, thinned out, as one that lasts as long as the longest: where to start
    must not depend on which run comes first (only one of them may reach a stop)."""
    longest = max(float(c.t[-1] - c.t[0]) for c in contexts)

    def joined(parts: Iterable[Array]) -> Array:
        return np.concatenate([x[::START_THIN] for x in parts])

    def of_all(parts: Iterable[Array | None]) -> Array | None:
        there = [x for x in parts if x is not None]
        return joined(there) if len(there) == len(contexts) else None

    q = joined(c.q for c in contexts)
    return replace(
        contexts[0],
        t=np.linspace(0.0, longest, len(q)),
        q=q,
        dq=joined(c.dq for c in contexts),
        ddq=joined(c.quiet_ddq for c in contexts),
        quieting=None,  # of one motion, which this is not
        levels=None,
        total=joined(c.total for c in contexts),
        temperature=of_all(c.temperature for c in contexts),
        rubbing=of_all(c.rubbing for c in contexts),
    )


def _best_starts(state: SearchState, effect: Effect, joints: tuple[int, ...]) -> list[Best]:
    own = effect.starts_by_own_equation
    found = _tried(state, effect, joints, _starts(state, effect, joints), own)
    if own:
        if any(s.blur for s in effect.shapes):  # rough in its shape: the best lies between starts
            best = _strongest(found, CLOSER_LOOKS)
            closer = [s for shape, _ in best for s in around(effect, shape)]
            found += _tried(state, effect, joints, closer, own)
        return _in_all_equations(state, effect, joints, _best_of_variants(effect, found))
    best = _best_of_variants(effect, found)
    most = max((partial.gain for _, partial in best), default=0.0)
    return [(shape, partial) for shape, partial in best if partial.gain >= WORTH_JUDGING * most]


def _tried(
    state: SearchState,
    effect: Effect,
    joints: tuple[int, ...],
    shapes: Sequence[Shape],
    own: bool,
    least: float = ABSORBED,
) -> list[Best]:
    """Those of the shapes that the fit side can tell, with what each adds."""
    width, falls = len(effect.coefficients), state.may_fall(effect)
    out: list[Best] = []
    for start in range(0, len(shapes), TOGETHER):
        part = shapes[start : start + TOGETHER]
        columns = state.train.columns(effect, joints, part, own)
        found = partials(state.fit, columns, effect, width, falls=falls, least=least)
        out += [(dict(s), p) for s, p in zip(part, found, strict=True) if p.identifiable]
    return out


def _strongest(found: Sequence[Best], count: int) -> list[Best]:
    return sorted(found, key=lambda best: -best[1].gain)[:count]


def _best_of_variants(effect: Effect, found: Sequence[Best]) -> list[Best]:
    """The strongest of every combination of choices (side, sign, law)."""
    choices = [s.name for s in effect.shapes if s.scale == "choice"]
    variants: dict[tuple[float | None, ...], Best] = {}
    for shape, partial in found:
        variant = tuple(shape.get(name) for name in choices)
        if variant not in variants or partial.gain > variants[variant][1].gain:
            variants[variant] = shape, partial
    return list(variants.values())


def _in_all_equations(
    state: SearchState, effect: Effect, joints: tuple[int, ...], found: list[Best]
) -> list[Best]:
    """The same shapes, judged on all joints that they reach."""
    out = []
    for shape, _ in found:
        columns = state.train.columns(effect, joints, [shape])
        (partial,) = partials(
            state.fit, columns, effect, len(effect.coefficients), falls=state.may_fall(effect)
        )
        if partial.identifiable:
            out.append((shape, partial))
    return out


def _starts(state: SearchState, effect: Effect, joints: tuple[int, ...]) -> list[Shape]:
    """Shapes to begin with."""
    if (before := state.same_before(effect, joints)) is not None:
        return [before.shape]
    if effect.line_order:
        peaks = order_peaks(state.train, state.train_residual(), joints[0])
        peaks += shaken_orders(state.train, joints[0])
        return [{effect.line_order: order} for order in peaks]
    # what reaches other joints asks for inertias, which the first run has at hand
    one_run = effect.reaches_other_joints
    context = state.train.contexts[0] if one_run else all_motion(state.train.contexts)
    starts = list(effect.starts(context, joints))
    if (choice := effect.one_of_each) == "":
        return starts
    there = [t for t in state.terms if (t.effect_id, t.joints) == (effect.id, joints)]
    taken = {t.shape[choice] for t in there}
    return [start for start in starts if start[choice] not in taken]
