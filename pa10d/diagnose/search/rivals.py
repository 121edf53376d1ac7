"""Whether a rival, in the model instead of what was named, is one still.

Candidates are held against each other by what they take of an error. Where each takes nearly all of
it, what chance does on other joints outweighs, by the measure of that error, five times as much
that one of them leaves. So a rival is fitted as the finding was, and both are held against each
other by what the finding leaves, which is the noise as far as anybody knows.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from pa10d.diagnose.constants import MATERIAL_GAIN, TELL_APART
from pa10d.diagnose.evidence.errors_of import term_covariance
from pa10d.diagnose.evidence.held_out import rivalry
from pa10d.diagnose.regression.shapes import free_shapes
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.candidates import scan, sharpened
from pa10d.diagnose.search.harm import harmful
from pa10d.diagnose.search.judging import JudgedCandidate
from pa10d.diagnose.search.refitting import settled
from pa10d.model import Term
from pa10d.regression.per_joint import rms


def rival_yet(state: SearchState, index: int, rival: JudgedCandidate, fixed: int) -> bool:
    """Can it be what it is called, and does it leave about as little as terms[index] of the state?
    fixed: terms that the model was given."""
    other = _in_its_place(state, index, rival)
    if other is None:
        return False
    if rival.candidate.effect.series_spring or state.terms[index].effect.series_spring:
        return True  # others bend the bodies as well, until they are followed
    spoken = _spoken(state, index, rival)
    if not leaves_more(state, other, spoken):
        return True
    return not leaves_more(state, settled(other, fixed, rounds=1), spoken)


def rather(
    state: SearchState, index: int, rival: JudgedCandidate, fixed: int
) -> SearchState | None:
    """The state with a rival in the place of terms[index], where that leaves clearly and materially
    less held out, and on no joint more of the fit side. The plainest of those that could not be
    told apart was chosen beside an error that others have taken since."""
    springs = rival.candidate.effect.series_spring or state.terms[index].effect.series_spring
    other = None if springs else _in_its_place(state, index, rival)
    if other is None:
        return None
    other = settled(other, fixed, rounds=1)
    spoken = _spoken(state, index, rival)
    fitted = all(other.fit.rms()[j] < state.fit.rms()[j] for j in spoken)
    better = fitted and leaves_more(other, state, spoken) and not harmful(state, other)
    return other if better else None


def of_another_kind(state: SearchState, index: int, fixed: int) -> SearchState | None:
    """The state with terms[index] as another kind of its effect (bristles that are damped, or not),
    where that leaves clearly and materially less held out, and less of the fit side; of kinds with
    as many numbers clearly is enough. Which kind it is was chosen by a start, before it was
    refined, beside an error that others have taken since.
    """
    term = state.terms[index]
    for other in _other_kinds(state, index, fixed):
        fitted = all(other.fit.rms()[j] < state.fit.rms()[j] for j in term.joints)
        clearly = _leads if _as_many(term, other.terms[index]) else leaves_more
        if fitted and clearly(other, state, term.joints) and not harmful(state, other):
            return other
    return None


def kinds_untold(state: SearchState, index: int, fixed: int) -> list[Term]:
    """terms[index] as another kind of its effect with as many numbers, where that leaves not
    clearly more held out."""
    term = state.terms[index]
    if state.frozen or not any(s.optional and s.says for s in term.effect.shapes):
        return []
    return [
        other.terms[index]
        for other in _other_kinds(state, index, fixed)
        if _as_many(term, other.terms[index]) and not _leads(state, other, term.joints)
    ]


def _other_kinds(state: SearchState, index: int, fixed: int) -> Iterator[SearchState]:
    """With each other kind of the effect in the place of terms[index], settled."""
    term, bare = state.terms[index], state.copy()
    choices = [s.name for s in term.effect.shapes if s.scale == "choice"]
    bare.drop(index)
    bare.refit()
    for one in sharpened(bare, scan(bare, [(term.effect, term.joints)])):
        if all(one.shape.get(name) == term.shape.get(name) for name in choices):
            continue
        other = state.copy()
        other.replace_term(index, one.term)
        other.refit()
        yield settled(other, fixed, rounds=1)


def _as_many(one: Term, other: Term) -> bool:
    """Have both kinds as many numbers?"""
    return len(free_shapes(one.effect, one.shape)) == len(free_shapes(other.effect, other.shape))


def _in_its_place(state: SearchState, index: int, rival: JudgedCandidate) -> SearchState | None:
    """A copy with a rival instead of terms[index]; None where it cannot be what it is called."""
    other = state.copy()
    other.drop(index)
    other.push(rival.candidate.term)
    other.refit()
    return other if _could_be(other, rival) else None


def _spoken(state: SearchState, index: int, rival: JudgedCandidate) -> list[int]:
    """Joints of which either speaks."""
    term, every = state.terms[index], np.arange(state.held.n)
    own, others = every[term.effect.speaks_on(term.joints)], every[rival.speaks_on]
    return sorted({*own.tolist(), *others.tolist()})


def leaves_more(named: SearchState, other: SearchState, joints: Iterable[int]) -> bool:
    """Does the other state leave clearly and materially more of the held-out side on these joints
    than the one with what was named?"""
    asked = list(joints)
    before, after = named.held_residual(), other.held_residual()
    alike = all(rms(after[j]) < (1.0 + MATERIAL_GAIN) * rms(before[j]) for j in asked)
    return not alike and _leads(named, other, asked)


def _leads(named: SearchState, other: SearchState, joints: Iterable[int]) -> bool:
    """Does the other state leave clearly more, be it as little as it may?"""
    before, after = named.held_residual(), other.held_residual()
    more = {j: before[j] - after[j] for j in joints}
    _, lead = rivalry(named.held, before, {j: np.zeros_like(m) for j, m in more.items()}, more)
    return lead >= TELL_APART


def _could_be(state: SearchState, rival: JudgedCandidate) -> bool:
    """By nuisances alone, which a fit chooses freely, it may explain what its own cannot."""
    kind, last = rival.candidate.effect, len(state.terms) - 1
    if not any(c.nuisance for c in kind.coefficients):
        return True
    covariance, _ = term_covariance(state, last)
    return kind.could_be(state.model.robot, state.terms[last].coefficients, covariance)
