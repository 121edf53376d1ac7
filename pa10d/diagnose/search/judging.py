"""The held-out evidence of one effect: of a candidate, or of a term that the model has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    HELD_OUT_LEVEL,
    LEAST_OWN,
    MATERIAL_GAIN,
    ROUNDED,
    SEARCH_LEVEL,
    SHORTLIST,
    SLOPES,
)
from pa10d.diagnose.evidence.errors_of import doubt_of
from pa10d.diagnose.evidence.held_out import Evidence, ModelUncertainty, fit_side_power, judge
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.partial import partials
from pa10d.diagnose.regression.state import SearchState, Suspects
from pa10d.diagnose.search.candidates import Candidate, held_columns
from pa10d.diagnose.search.ripple import chance_beside_neighbours, chance_of_line
from pa10d.effects import Effect, Shape
from pa10d.model import Term
from pa10d.regression.per_joint import PerJoint, rms

Array = NDArray[np.float64]
Place = tuple[str, tuple[int, ...]]


@dataclass
class JudgedCandidate:
    """A candidate with its held-out evidence, corrected for all that were judged beside it."""

    candidate: Candidate
    evidence: Evidence
    p_corrected: float
    change: PerJoint = field(repr=False, default_factory=dict)
    usual: Array | None = None
    fit_gain: float | None = None  # of the joints that speak, where not all of them do
    is_itself: bool = True
    acts: bool = True  # on the held-out side, too
    as_given: Array | None = None  # (n,) N·m RMS that a frozen model leaves as it was
    at_most: Array | None = None  # (n,) N·m RMS that it may leave though nothing changed

    @property
    def place(self) -> Place:
        """Effect and joints."""
        return self.candidate.effect.id, self.candidate.joints

    @property
    def speaks_on(self) -> list[int]:
        """Joints whose error speaks for or against it."""
        kind, joints = self.candidate.effect, self.candidate.joints
        return _speaking(kind, joints, self.evidence.before, self.usual)

    @property
    def gain(self) -> float:
        """Weighted squared error that it removes, on both sides together."""
        fit = self.candidate.gain if self.fit_gain is None else self.fit_gain
        return fit + float(np.sum(self.evidence.gains[self.speaks_on]))

    @property
    def complexity(self) -> int:
        """Number of free parameters that it spends."""
        return complexity(self.candidate)

    @property
    def acceptable(self) -> bool:
        """It holds, as the effect that it is called."""
        return self._holds and not self.candidate.effect.bent(self.candidate.shape)

    @property
    def bent(self) -> bool:
        """It holds, but for a shape at the end of its range, where it is another effect."""
        return self._holds and self.candidate.effect.bent(self.candidate.shape)

    @property
    def unseen(self) -> bool:
        """It would hold, but acts on the fit side alone: what it helps held out it does by what
        the bodies become beside it."""
        return self._explains and not self.acts

    @property
    def _holds(self) -> bool:
        return self._explains and self.acts

    @property
    def _explains(self) -> bool:
        """Significant, of the predicted size, material, itself, and harmful to no joint; of a model
        that is kept as it was, more than it lacked before, and less is left than it leaves as it
        is: moved within its own doubt to suit the fit side alone it may do worse than that."""
        e = self.evidence
        own = self.speaks_on
        if not own:
            return False
        drop = 1.0 - np.min(e.after[own] / np.maximum(self._before[own], 1e-300))
        sure = self.p_corrected < SEARCH_LEVEL and e.p_value < HELD_OUT_LEVEL
        return bool(
            self.is_itself
            and (sure or self.certain)
            and SLOPES[0] < e.slope < SLOPES[1]
            and drop > MATERIAL_GAIN
            and not e.worse
        )

    @property
    def certain(self) -> bool:
        """Does it take more of a joint's error than a frozen model may leave there though nothing
        changed? However slow, noise of that size cannot be what it takes."""
        if self.at_most is None:
            return False
        own = self.speaks_on
        taken = self._before[own] ** 2 - self.evidence.after[own] ** 2
        return bool(np.any(taken > self.at_most[own] ** 2))

    @property
    def _before(self) -> Array:
        before = self.evidence.before
        return before if self.as_given is None else np.minimum(before, self.as_given)


@dataclass(frozen=True)
class Judging:
    """Judges what a model lacks or has; suspects: all that were looked at for it; fixed: terms that
    it was given."""

    state: SearchState
    suspects: Suspects
    fixed: int

    def candidate(
        self, candidate: Candidate, among: int, seen: PerJoint, doubt: ModelUncertainty
    ) -> JudgedCandidate:
        """Held-out evidence of one candidate; seen: what it changes on the fit side (weighted);
        doubt: of the present model beside it."""
        fit, partial = self.state.fit, candidate.partial
        columns = held_columns(self.state, candidate)
        change = self.state.change(fit, columns, partial.seen, partial.theta)
        usual, left = self._usual(), self.state.held_residual()
        told = self._told(candidate, left, usual)
        found = self._evidence(left, change, doubt, told)
        p = self._corrected(fit, seen, candidate, found, among, told, change)
        return JudgedCandidate(
            candidate,
            found,
            p,
            change,
            usual,
            self._gain_of(fit, seen, told),
            self.is_itself(candidate.effect, candidate.joints, candidate.shape),
            _acts(columns, partial.theta, change),
            self.state.as_given,
            self.state.usual,
        )

    def _told(self, candidate: Candidate, left: PerJoint, usual: Array | None) -> set[int]:
        """Joints whose error speaks for or against it; all where it has nothing to say."""
        before = np.array([rms(left[j]) for j in sorted(left)])
        told = _speaking(candidate.effect, candidate.joints, before, usual)
        return {*told} or {*range(self.state.held.n)}

    def _gain_of(self, fit: LeastSquares, seen: PerJoint, told: set[int]) -> float | None:
        """Weighted squared error that a change takes of these joints on the fit side; None: of a
        model that is refitted all count, for all may gain by what it makes room for."""
        if self.state.usual is None:
            return None
        return float(sum(2 * p @ fit.residual[j] - p @ p for j, p in seen.items() if j in told))

    def _evidence(
        self, residual: PerJoint, change: PerJoint, doubt: ModelUncertainty, told: set[int]
    ) -> Evidence:
        """Of the joints whose error speaks for or against it. What it shifts elsewhere, by way of
        parameters that joints share, may do harm there, but says nothing of it: of a joint at rest
        on the fit side those are so unsure that they would drown what its own joint says."""
        side = self.state.held
        whole = judge(side, residual, change, doubt)
        if told >= change.keys():
            return whole
        own = judge(side, residual, {j: p for j, p in change.items() if j in told}, doubt)
        return replace(
            whole, slope=own.slope, z=own.z, p_value=own.p_value, cluster_t=own.cluster_t
        )

    def _corrected(
        self,
        fit: LeastSquares,
        seen: PerJoint,
        candidate: Candidate,
        found: Evidence,
        among: int,
        told: set[int],
        change: PerJoint,
    ) -> float:
        """Both sides' evidence (Fisher), corrected for every suspect on the fit side, on which
        the candidate was chosen, and for those judged beside it on the held-out side."""
        if self.state.usual is not None:
            seen = {j: s for j, s in seen.items() if j in told}
        power = fit_side_power(self.state.train, fit.residual, seen)
        if candidate.effect.line_order:
            own = chance_of_line(self.state.train, candidate.joints[0], power)
        else:
            own = float(scipy.stats.chi2.sf(power, complexity(candidate)))
        chosen = min(1.0, own * len(self.suspects))
        both = scipy.stats.chi2.sf(
            -2.0 * (np.log(max(chosen, 1e-300)) + np.log(max(found.p_value, 1e-300))), 4
        )
        line, beside = candidate.effect.line_order, 0.0
        if line:
            left, order = self.state.held_residual(fit), candidate.shape[line]
            joint = candidate.joints[0]
            own_change = change.get(joint)
            beside = chance_beside_neighbours(self.state.held, left, joint, order, own_change)
        return float(max(min(1.0, both * among), beside))

    def term(self, index: int) -> JudgedCandidate:
        """Held-out evidence of a term already in the model, on top of all others."""
        rest = self.state.fit_without(index)
        term = self.state.terms[index]
        train, held = self.state.blocks[index]
        kind = term.effect
        falls = index >= self.fixed and self.state.may_fall(kind)
        width = len(kind.coefficients)
        partial = partials(rest, train, kind, width, falls=falls, least=ROUNDED)[0]
        change = self.state.change(rest, held, partial.seen, partial.theta)
        doubt = doubt_of(self.state, rest, self.state.fit.residual)
        candidate = Candidate(term.effect, term.joints, term.shape, partial)
        usual, left = self._usual(but=index), self.state.held_residual(rest)
        told = self._told(candidate, left, usual)
        found = self._evidence(left, change, doubt, told)
        seen = seen_change(rest, train, candidate)
        p = self._corrected(rest, seen, candidate, found, SHORTLIST, told, change)
        return JudgedCandidate(
            candidate,
            found,
            p,
            {},
            usual,
            self._gain_of(rest, seen, told),
            self.is_itself(candidate.effect, candidate.joints, candidate.shape),
            _acts(held, partial.theta, change),
            self.state.as_given,
            self.state.usual,
        )

    def is_itself(self, kind: Effect, joints: Sequence[int], shape: Shape) -> bool:
        """Where the fit side has been."""
        if len(joints) != 1:
            return True
        q = [context.q[:, joints[0]] for context in self.state.train.contexts]
        low, high = min(float(x.min()) for x in q), max(float(x.max()) for x in q)
        return kind.is_itself(shape, low, high)

    def _usual(self, but: int | None = None) -> Array | None:
        """(n,) N·m that a joint may keep though nothing changed; none where the model as it was
        leaves more and nothing has been found: within its own uncertainty it hides most changes;
        anything where it leaves no more: what moving it did to a joint is no change there."""
        usual, given = self.state.usual, self.state.as_given
        if usual is None or given is None:
            return usual
        terms = enumerate(self.state.terms[self.fixed :], self.fixed)
        found = spoken_of([term for index, term in terms if index != but], len(usual))
        return np.where(given > usual, np.where(found, usual, 0.0), np.inf)


def spoken_of(terms: Sequence[Term], n: int) -> NDArray[np.bool_]:
    """(n,) joints of which one of these effects says what changed."""
    out = np.zeros(n, dtype=bool)
    for term in terms:
        out[term.effect.speaks_on(term.joints)] = True
    return out


def _speaking(kind: Effect, joints: Sequence[int], before: Array, usual: Array | None) -> list[int]:
    """Joints whose error speaks for or against an effect; for a change none that keeps no more than
    it always lacked: what suits that would outweigh the joints where something came. before, usual:
    (n,) N·m RMS."""
    own = np.arange(len(before))[kind.speaks_on(joints)]
    return [int(j) for j in own if usual is None or before[j] > usual[j]]


def _acts(columns: PerJoint, theta: Array, change: PerJoint) -> bool:
    """Does a candidate act on the held-out side? One that has no torque there, and helps by what
    the bodies become beside it on the other side, is not seen."""
    own = sum(float(np.sum((c @ theta) ** 2)) for c in columns.values())
    changed = sum(float(np.sum(change[j] ** 2)) for j in columns)
    return own > LEAST_OWN * changed


def seen_change(fit: LeastSquares, columns: PerJoint, candidate: Candidate) -> PerJoint:
    """joint -> (m_j,) weighted: what a candidate changes on the fit side, the model refitted."""
    partial = candidate.partial
    absorbed = partial.seen @ partial.theta
    change = {j: -(q @ absorbed) for j, q in fit.basis.items()}
    for j, c in columns.items():
        change[j] = change[j] + c @ partial.theta / fit.sigma[j]
    return change


def complexity(candidate: Candidate) -> int:
    """Number of free parameters of an effect."""
    kind = candidate.effect
    free = sum(not c.nuisance for c in kind.coefficients)
    return free + sum(s.scale != "choice" for s in kind.shapes_in(candidate.shape))
