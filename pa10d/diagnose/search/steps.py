"""Forward steps with backward pruning: add what is missing until nothing significant is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    CLOSER_STEPS,
    HELD_OUT_LEVEL,
    LEAST_GAIN,
    MATERIAL_GAIN,
    MORE_ROUNDS,
    MOST_STEPS,
    MUCH_WORSE,
    OUTDONE,
    PER_JOINT,
    SAME_DIRECTION,
    SEARCH_LEVEL,
    SHORTLIST,
    SLOPES,
    TELL_APART,
    WORTH_A_ROUND,
)
from pa10d.diagnose.evidence.errors_of import ModelUncertainties, doubt_of, term_covariance
from pa10d.diagnose.evidence.held_out import (
    Evidence,
    ModelUncertainty,
    fit_side_power,
    judge,
    rivalry,
)
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.partial import PartialFit, partials
from pa10d.diagnose.regression.shapes import approach, around, free_shapes, refine
from pa10d.diagnose.regression.slopes import newton_move
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.candidates import Candidate, held_columns, scan, sharpened
from pa10d.diagnose.search.ripple import chance_beside_neighbours, chance_of_line
from pa10d.diagnose.search.springs import follow, with_springs
from pa10d.diagnose.search.timing import align
from pa10d.diagnose.unknown.structure import all_maps
from pa10d.effects import Effect
from pa10d.model import Term
from pa10d.regression.per_joint import PerJoint, predict

Array = NDArray[np.float64]
Place = tuple[str, tuple[int, ...]]
Suspects = Sequence[tuple[Effect, tuple[int, ...]]]


@dataclass
class JudgedCandidate:
    """A candidate with its held-out evidence, corrected for all that were judged beside it."""

    candidate: Candidate
    evidence: Evidence
    p_corrected: float
    change: PerJoint = field(repr=False, default_factory=dict)

    @property
    def place(self) -> Place:
        """Effect and joints."""
        return self.candidate.effect.id, self.candidate.joints

    @property
    def speaks_on(self) -> list[int] | slice:
        """Joints whose error speaks for or against it."""
        return self.candidate.effect.speaks_on(self.candidate.joints)

    @property
    def gain(self) -> float:
        """Weighted squared error that it removes, on both sides together."""
        return self.candidate.gain + float(np.sum(self.evidence.gains[self.speaks_on]))

    @property
    def complexity(self) -> int:
        """Number of free parameters that it spends."""
        return complexity(self.candidate)

    @property
    def acceptable(self) -> bool:
        """Significant, of the predicted size, material, itself, and harmful to no joint."""
        e, kind, shape = self.evidence, self.candidate.effect, self.candidate.shape
        own = self.speaks_on
        drop = 1.0 - np.min(e.after[own] / np.maximum(e.before[own], 1e-300))
        degenerate = any(s.at_edge(shape[s.name]) for s in kind.shapes_in(shape))
        return bool(
            not degenerate
            and self.p_corrected < SEARCH_LEVEL
            and e.p_value < HELD_OUT_LEVEL
            and SLOPES[0] < e.slope < SLOPES[1]
            and drop > MATERIAL_GAIN
            and not e.worse
        )


@dataclass
class Addition:
    """One addition: what was chosen, and what else explained the same error nearly as well."""

    chosen: JudgedCandidate
    rivals: list[JudgedCandidate]  # cannot be told apart from it on this data
    before: Array
    after: Array


@dataclass
class Search:
    """The course of a search: ``state`` is the model as far as it has come."""

    state: SearchState
    suspects: Suspects
    fixed: int
    steps: list[Addition] = field(default_factory=list)
    progress: Callable[[float, str], None] = lambda share, text: None

    def run(self, steps: int = MOST_STEPS) -> Search:
        """Add, prune, add again; once more without what turned out unsure in the end."""
        self._align()
        refused: set[Place] = set()
        while True:
            self._forward(steps, refused)
            unsure = self.unsure()
            if not unsure:
                return self
            refused |= unsure

    def _forward(self, steps: int, refused: set[Place]) -> None:
        """refused: what was in the model and did not stay. What could not come in may yet do so
        beside what comes next: that may have been why."""
        put_off: set[Place] = set()
        added = 0
        while added < steps:
            self.progress(added / steps, f"step {added + 1}: looking through the library")
            judged = self.look()
            good = [j for j in judged if j.acceptable and j.place not in refused | put_off]
            before = rms(self.state.held_residual())
            spring = self.spring_beside(good)
            if spring is not None:
                refused |= self.prune() | self.reconsider()
                self.steps.append(Addition(*spring, before, rms(self.state.held_residual())))
                added, put_off = added + 1, set()
                continue
            if not good:
                break
            chosen, tied = self.prefer(good, judged)
            dropped = self.take(chosen)
            if dropped is None:
                put_off.add(chosen.place)
                continue
            refused |= dropped | self.reconsider()
            self.steps.append(Addition(chosen, tied, before, rms(self.state.held_residual())))
            added, put_off = added + 1, set()

    def unsure(self) -> set[Place]:
        """Drop findings that show only where joints contradict each other and whose own values, all
        that is known of their doubt included, may as well be zero; says which. Noise as slow as
        gravity leads bodies and joints apart, too, and its spectrum is not seen in so short a time.
        """
        if self.state.frozen:
            return set()
        dropped: set[Place] = set()
        for index in reversed(range(self.fixed, len(self.state.terms))):
            term = self.state.terms[index]
            if not term.effect.seen_by_shared_bodies:
                continue
            told = [not c.nuisance for c in term.effect.coefficients]
            covariance = term_covariance(self.state, index)[0][np.ix_(told, told)]
            value = term.coefficients[told]
            size = float(value @ np.linalg.pinv(covariance, hermitian=True) @ value)
            alike = sum(e.seen_by_shared_bodies for e, _ in self.suspects)
            if float(scipy.stats.chi2.sf(size, len(value))) * alike > SEARCH_LEVEL:
                dropped.add((term.effect_id, term.joints))
                self.state.drop(index)
        if dropped:
            self.settle()
        return dropped

    def take(self, chosen: JudgedCandidate) -> set[Place] | None:
        """Add a candidate and settle; says what became redundant, or None where, refitted around
        it, the model got worse elsewhere or it does not hold itself: not what was promised.

        A joint whose error fell draws the fit towards itself. On weakly excited data that alone
        may spoil another joint, so a second attempt leaves the weights as they were; where they
        were left before, it lets them go: what would have been spoiled may be explained by now.
        """
        saved = self.state.copy()
        left = saved.problem.sigma
        for weights in (left, saved.fit.sigma if left is None else None):
            self.state = saved.copy()
            self.state.weigh(weights)
            self.state.push(chosen.candidate.term)
            self.settle()
            dropped = self.prune()
            if chosen.place in dropped or spoils(saved, self.state):
                continue
            if not turns_worse(saved, self.state):
                return dropped
            beside = self._with_companion(saved, chosen)
            if beside is not None:
                return dropped | beside
        self.state = saved
        return None

    def _with_companion(self, saved: SearchState, chosen: JudgedCandidate) -> set[Place] | None:
        """What holds in steady motion and makes only reversals worse may lack what happens there:
        friction that is higher at low speed, and builds up over a way. Add the best other effect of
        the same joint, if with both nothing is worse than before; says what became redundant."""
        there = [(e, joints) for e, joints in self.suspects if joints == chosen.candidate.joints]
        good = [j for j in replace(self, suspects=there).look() if j.acceptable]
        if not good:
            return None
        best = max(good, key=lambda j: j.gain)
        self.state.push(best.candidate.term)
        self.settle()
        dropped = self.prune()
        if dropped & {chosen.place, best.place} or harmful(saved, self.state):
            return None
        return dropped

    def spring_beside(
        self, good: Sequence[JudgedCandidate]
    ) -> tuple[JudgedCandidate, list[JudgedCandidate]] | None:
        """Add the spring that, with the bodies fitted behind it, takes more than any candidate does
        beside bodies that have bent to it; the other joint's where the data cannot tell."""
        most = max((j.candidate.gain for j in good), default=LEAST_GAIN)
        told = []
        for state in with_springs(self.state, self.suspects, most):
            judged = replace(self, state=state).judge_term(len(state.terms) - 1)
            taken = taken_by(self.state, state)
            if judged.acceptable and taken > most and not harmful(self.state, state):
                told.append((state, judged, rms(state.held_residual())))
        if not told:
            return None
        self.state, chosen, left = told[0]
        for index in range(self.fixed):  # how sharp friction turns round was not to be seen before
            if self.state.terms[index].effect.smoothed_over:
                self._refine(index)
        tied = [j for _, j, r in told[1:] if np.all(r < (1.0 + MATERIAL_GAIN) * left)]
        return chosen, tied

    def best(self, effect: Effect, joints: tuple[int, ...]) -> Candidate | None:
        """The best shape of one effect in one place, or None where the data cannot show it."""
        found = scan(self.state, [(effect, joints)])
        return sharpened(self.state, found)[0] if found else None

    def rivals_of(self, term: Term) -> list[JudgedCandidate]:
        """What explained the same error equally well when the term was chosen."""
        for step in self.steps:
            if step.chosen.place == (term.effect_id, term.joints):
                return step.rivals
        return []

    def contest(self) -> list[int]:
        """Joints on which the findings are beaten by a plain smooth map of the motion.

        A true effect explains its error better than any generic map can. Where a map alone
        leaves less than 1/OUTDONE of what the findings leave, they were only imitating something
        that the library does not have: they are dropped, and the joint is left unexplained.
        """
        concerned = sorted({j for t in self.state.terms[self.fixed :] for j in t.joints})
        if not concerned:
            return []
        bare = self.state.bare(self.fixed)
        now = self.state.held_residual()
        outdone = [
            maps[0].joint
            for maps in all_maps(bare, concerned)
            if any(m.outdoes(now, OUTDONE) for m in maps)
        ]
        for index in reversed(range(self.fixed, len(self.state.terms))):
            if any(j in outdone for j in self.state.terms[index].joints):
                self.state.drop(index)
        if outdone:
            self.settle()
        return outdone

    def look(self) -> list[JudgedCandidate]:
        """Scan all suspects and judge the shortlist on the held-out side."""
        # of a model that stays as it is, what it has already may have changed
        first = self.fixed if self.state.frozen else 0
        present = {(t.effect_id, t.joints) for t in self.state.terms[first:]}
        open_suspects = [
            (e, joints)
            for e, joints in self.suspects
            if (e.id, joints) not in present or e.repeatable
        ]
        found = self._shortlist(scan(self.state, open_suspects))
        sharp = sharpened(self.state, found)
        columns = [self._columns(c) for c in sharp]
        seen = [_seen_change(self.state.fit, k, c) for k, c in zip(columns, sharp, strict=True)]
        own = [{j: s[j] for j in k} for k, s in zip(columns, seen, strict=True)]
        doubts = ModelUncertainties.of(self.state, own)
        return [
            self.judge(c, len(found), s, doubts.beside(o))
            for c, s, o in zip(sharp, seen, own, strict=True)
        ]

    def _columns(self, candidate: Candidate) -> PerJoint:
        return self.state.train.columns(candidate.effect, candidate.joints, [candidate.shape])

    def _shortlist(self, found: list[Candidate]) -> list[Candidate]:
        """The strongest of every joint, as far as the fit side alone does not speak against them:
        a joint with a large error must not hide what another one has to say."""
        per_joint: dict[int, set[str]] = {}
        out = []
        for candidate in found:
            beside = candidate.joints if not candidate.effect.seen_by_shared_bodies else ()
            there = [per_joint.setdefault(j, set()) for j in beside or (-1,)]
            kind = candidate.effect.id
            if all(len(kinds) >= PER_JOINT and kind not in kinds for kinds in there):
                continue
            if candidate.gain < LEAST_GAIN:
                continue
            for kinds in there:
                kinds.add(kind)
            out.append(candidate)
        return out

    def judge(
        self, candidate: Candidate, among: int, seen: PerJoint, doubt: ModelUncertainty
    ) -> JudgedCandidate:
        """Held-out evidence of one candidate; seen: what it changes on the fit side (weighted);
        doubt: of the present model beside it."""
        fit, partial = self.state.fit, candidate.partial
        change = self.state.change(
            fit, held_columns(self.state, candidate), partial.seen, partial.theta
        )
        found = judge(self.state.held, self.state.held_residual(), change, doubt)
        p = self._corrected(fit, seen, candidate, found, among)
        return JudgedCandidate(candidate, found, p, change)

    def _corrected(
        self, fit: LeastSquares, seen: PerJoint, candidate: Candidate, found: Evidence, among: int
    ) -> float:
        """Both sides' evidence (Fisher), corrected for every suspect on the fit side, on which
        the candidate was chosen, and for those judged beside it on the held-out side."""
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
            beside = chance_beside_neighbours(self.state.held, left, joint, order)
        return float(max(min(1.0, both * among), beside))

    def prefer(
        self, good: list[JudgedCandidate], judged: list[JudgedCandidate]
    ) -> tuple[JudgedCandidate, list[JudgedCandidate]]:
        """The best candidate, or the simplest of those that this data cannot tell from it."""
        best = max(good, key=lambda j: j.gain)
        tied = [j for j in judged if j is best or self._tied(best, j)]
        chosen = min((j for j in tied if j in good), key=lambda j: (j.complexity, -j.gain))
        return chosen, [j for j in tied if j.place != chosen.place]

    def _tied(self, best: JudgedCandidate, other: JudgedCandidate) -> bool:
        """By what they change where either of them speaks: what they shift elsewhere is the same
        for both but for chance, and where another joint still lacks something that is much."""
        residual = self.state.held_residual()
        every = np.arange(self.state.held.n)
        spoken = {int(j) for one in (best, other) for j in every[one.speaks_on]}
        a, b = ({j: c for j, c in one.change.items() if j in spoken} for one in (best, other))
        overlap, z = rivalry(self.state.held, residual, a, b)
        alike = np.all(other.evidence.after < (1.0 + MATERIAL_GAIN) * best.evidence.after)
        return overlap > SAME_DIRECTION and (z < TELL_APART or bool(alike))

    def settle(self, rounds: int = 2) -> None:
        """Refit; loads of the new model; shapes of all nonlinear terms anew; as many more rounds as
        bring something. The best of them counts. Where loads and shapes draw each other on (a gap,
        a spring), one that brings nothing does not end it."""
        self.state.refit()
        self._align()
        drawn = self.state.drawn_by_loads
        begun = self.state.loads
        best, least, idle = self.state, np.inf, 0
        for number in range(1, rounds + MORE_ROUNDS + 1):
            self._relinearise()
            self.state.relook()
            self.state.refit()
            for index, term in enumerate(self.state.terms):
                early = number == 1 and only_rounds(term)  # it would imitate what is not settled
                if term.effect.shapes and not early and self._worth_refining(index):
                    self._refine(index)
            self.state.relook()
            self.state.refit()
            left = float(np.sum(np.log(self.state.fit.rms())))
            idle = 0 if left < least - WORTH_A_ROUND else idle + 1
            if left < least:
                best, least = self.state.copy(), left
            if number >= rounds and idle > drawn:
                break
        self.state = self._with_springs_followed(best, least, begun)

    def _with_springs_followed(
        self, best: SearchState, least: float, begun: Array | None
    ) -> SearchState:
        """The same with bodies and springs fitted at once, where that leaves less."""
        for index, term in enumerate(best.terms):
            if not term.effect.series_spring or best.frozen:
                continue
            bodies = [h for h in (begun, best.loads) if h is not None]
            found = follow(best, index, bodies)
            left = np.inf if found is None else float(np.sum(np.log(found.fit.rms())))
            if found is not None and left < least:
                best, least = found, left
        return best

    def prune(self) -> set[Place]:
        """Drop additions that later ones made redundant, the least useful first; says which."""
        dropped: set[Place] = set()
        while len(self.state.terms) > self.fixed:
            weakest = None
            for index in range(self.fixed, len(self.state.terms)):
                judged = self.judge_term(index)
                if not judged.acceptable and (
                    weakest is None or judged.evidence.gain < weakest[1].evidence.gain
                ):
                    weakest = (index, judged)
            if weakest is None:
                break
            dropped.add(weakest[1].place)
            self.state.drop(weakest[0])
            self.state.refit()
        return dropped

    def reconsider(self) -> set[Place]:
        """Drop earlier findings that the newest one, fitted again in their absence, can do
        without: what imitated it until it was there. Says which."""
        dropped: set[Place] = set()
        for index in reversed(range(self.fixed, len(self.state.terms) - 1)):
            if not set(self.state.terms[index].joints) & set(self.state.terms[-1].joints):
                continue
            saved, earlier = self.state.copy(), self.state.terms[index]
            before = rms(self.state.held_residual())
            self.state.drop(index)
            self.settle()
            if np.any(rms(self.state.held_residual()) > (1.0 + MATERIAL_GAIN) * before):
                self.state = saved
            else:
                dropped.add((earlier.effect_id, earlier.joints))
        return dropped

    def judge_term(self, index: int) -> JudgedCandidate:
        """Held-out evidence of a term already in the model, on top of all others."""
        rest = self.state.fit.without(self.state.place(index))
        term = self.state.terms[index]
        train, held = self.state.blocks[index]
        kind = term.effect
        falls = index >= self.fixed and self.state.may_fall(kind)
        partial = partials(rest, train, kind, len(kind.coefficients), falls=falls)[0]
        change = self.state.change(rest, held, partial.seen, partial.theta)
        doubt = doubt_of(self.state, rest, self.state.fit.residual)
        found = judge(self.state.held, self.state.held_residual(rest), change, doubt)
        candidate = Candidate(term.effect, term.joints, term.shape, partial)
        seen = _seen_change(rest, train, candidate)
        p = self._corrected(rest, seen, candidate, found, SHORTLIST)
        return JudgedCandidate(candidate, found, p)

    def _align(self) -> None:
        """A frozen model brings its own timing: nothing there may be explained by moving it."""
        if not self.state.frozen:
            align(self.state)

    def _relinearise(self) -> None:
        for index, term in enumerate(self.state.terms[self.fixed :], self.fixed):
            shape = term.effect.relinearised(term.coefficients, term.shape)
            if shape != term.shape:
                self.state.problem = self.state.problem.with_term(index, replace(term, shape=shape))

    def _worth_refining(self, index: int) -> bool:
        """Findings; and of the given terms those on joints that a finding can have changed."""
        found = self.state.terms[self.fixed :]
        reached = any(t.effect.reaches_other_joints for t in found) and not self.state.frozen
        if index >= self.fixed or reached:
            return True
        return self.state.terms[index].joints[0] in {j for t in found for j in t.joints}

    def _refine(self, index: int) -> None:
        term = self.state.terms[index]
        rest = self.state.fit.without(self.state.place(index))
        width = len(term.effect.coefficients)
        falls = index >= self.fixed and self.state.may_fall(term.effect)

        train = self.state.train

        def fitted(shape: dict[str, float]) -> PartialFit:
            columns = train.columns(term.effect, term.joints, [shape])
            return partials(rest, columns, term.effect, width, falls=falls)[0]

        def gain(shape: dict[str, float]) -> float:
            return fitted(shape).gain

        def move(shape: dict[str, float]) -> Array:
            there = replace(term, shape=shape, coefficients=fitted(shape).theta)
            return newton_move(train, rest, there)

        if any(s.blur for s in free_shapes(term.effect, term.shape)):  # knocks: rough everywhere
            shape = self._closer(index, rest, falls)
        elif term.effect.reaches_other_joints:  # links thrown about, and dear to compute
            shape = refine(term.effect, term.shape, gain, evaluations=10)
        else:
            shape = approach(term.effect, term.shape, gain, move)
        if only_rounds(term) and gain(shape) < gain(dict(term.shape)) + LEAST_GAIN:
            return  # how sharp a corner is shows only on what passes it slowly: no guessing
        if shape != term.shape:
            self.state.replace_term(index, replace(term, shape=shape))
            self.state.refit()

    def _closer(self, index: int, rest: LeastSquares, falls: bool) -> dict[str, float]:
        """The best of the shapes around a rough one, then of those closer around that."""
        term, train = self.state.terms[index], self.state.train
        best, most = dict(term.shape), -np.inf
        for part in CLOSER_STEPS:
            shapes = around(term.effect, best, part)
            columns = train.columns(term.effect, term.joints, shapes)
            width = len(term.effect.coefficients)
            found = partials(rest, columns, term.effect, width, falls=falls)
            gains = [p.gain for p in found]
            if max(gains) > most:
                best, most = shapes[int(np.argmax(gains))], max(gains)
        return best


def taken_by(before: SearchState, after: SearchState) -> float:
    """Weighted squared error that is gone from the fit side, in units of what was left before."""
    share = 1.0 - (after.fit.rms() / before.fit.rms()) ** 2
    return float(np.sum(share * [len(before.train.tau[j]) for j in range(before.train.n)]))


def _seen_change(fit: LeastSquares, columns: PerJoint, candidate: Candidate) -> PerJoint:
    """joint -> (m_j,) weighted: what a candidate changes on the fit side, the model refitted."""
    partial = candidate.partial
    absorbed = partial.seen @ partial.theta
    change = {j: -(q @ absorbed) for j, q in fit.basis.items()}
    for j, c in columns.items():
        change[j] = change[j] + c @ partial.theta / fit.sigma[j]
    return change


def harmful(before: SearchState, after: SearchState) -> bool:
    """Is anything worse, in steady motion or where the arm turns round?"""
    return spoils(before, after) or turns_worse(before, after)


def spoils(before: SearchState, after: SearchState) -> bool:
    """Did the errors, each joint by its own measure, grow on the whole, or much and significantly
    on one joint?

    On short recordings a right effect may move what several joints share within its uncertainty,
    and away from where a joint happened to do well: that is no reason to go without it.
    """
    r0, r1 = before.held_residual(), after.held_residual()
    ratio = rms(r1) / np.maximum(rms(r0), 1e-300)
    if np.sum(ratio**2 - 1.0) > 0:
        return True
    if np.max(ratio) > 1.0 + MUCH_WORSE:
        moved = {j: r0[j] - r1[j] for j in r0}
        worse = judge(after.held, r0, moved, doubt_of(after)).worse
        return any(ratio[j] > 1.0 + MUCH_WORSE for j in worse)
    return False


def turns_worse(before: SearchState, after: SearchState) -> bool:
    """The same with reversals, which no fit looks at, where a joint did not get worse without them
    already."""
    ratio = rms(after.held_residual()) / np.maximum(rms(before.held_residual()), 1e-300)
    everywhere = after.moving_rms() / np.maximum(before.moving_rms(), 1e-300)
    beyond = everywhere / np.maximum(ratio, 1.0)
    return bool(np.sum(everywhere**2 - 1.0) > 0 or np.max(beyond) > 1.0 + MUCH_WORSE)


def complexity(candidate: Candidate) -> int:
    """Number of free parameters of an effect."""
    kind = candidate.effect
    free = sum(not c.nuisance for c in kind.coefficients)
    return free + sum(s.scale != "choice" for s in kind.shapes_in(candidate.shape))


def rms(residual: dict[int, Array]) -> Array:
    """(n,) N·m."""
    return np.array([float(np.sqrt(np.mean(residual[j] ** 2))) for j in sorted(residual)])


def explained(state: SearchState) -> Array:
    """(n,) RMS of the model's torque on the held-out side, N·m."""
    return rms(predict(state.held_matrix, state.fit.beta))


def only_rounds(term: Term) -> bool:
    """Whether all that is free of a term's shape is how sharp a corner is."""
    return all(s.smoothing for s in free_shapes(term.effect, term.shape))
