"""Forward steps with backward pruning: add what is missing until nothing significant is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    AS_WELL,
    LEAST_GAIN,
    LEAST_STEPS,
    MATERIAL_GAIN,
    OUTDONE,
    SEARCH_LEVEL,
    SPRINGS_FOLLOWED,
    STEPS_PER_JOINT,
    TIMING_ROUNDS,
)
from pa10d.diagnose.evidence.errors_of import term_covariance
from pa10d.diagnose.regression.clear_of_knocks import blurred, clear_of_knocks
from pa10d.diagnose.regression.shaken import made_held_out
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.candidates import Candidate, scan, sharpened
from pa10d.diagnose.search.channel import (
    agree_by_now,
    behind_channel,
    beside_springs,
    tuned,
)
from pa10d.diagnose.search.corners import (
    as_unsure,
    corners_anew,
    sharper_instead,
    with_corners,
)
from pa10d.diagnose.search.dead_bands import Bands, dead_bands
from pa10d.diagnose.search.harm import harmful, rms, spoils, taken_by, turns_worse
from pa10d.diagnose.search.judging import JudgedCandidate, Judging, Place, Suspects
from pa10d.diagnose.search.looking import (
    absorbed_rivals,
    bent_rivals,
    holds_clear,
    look,
    prefer,
    still_tied,
)
from pa10d.diagnose.search.pairs import pair_beside
from pa10d.diagnose.search.refining import refine
from pa10d.diagnose.search.refitting import settled
from pa10d.diagnose.search.rivals import of_another_kind, rather, rival_yet
from pa10d.diagnose.search.springs import promising, with_firm_spring, with_springs
from pa10d.diagnose.search.timing import align, late_joints, move
from pa10d.diagnose.search.turning import told_by_reversals
from pa10d.diagnose.unknown.stepping import steps_in_time
from pa10d.diagnose.unknown.structure import Structure, all_maps, without
from pa10d.effects import Effect, effect
from pa10d.model import Term

Array = NDArray[np.float64]


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
    floor: Array | None = None  # (n,) N·m of the held-out side; nan where it is not known
    steps: list[Addition] = field(default_factory=list)
    rival_gains: dict[int, Structure] = field(default_factory=dict)  # by joint: leave less alone
    outdone: dict[int, tuple[tuple[str, ...], float]] = field(default_factory=dict)  # see contest
    dead_bands: Bands = field(default_factory=dict)  # of the readings, likewise
    bent: tuple[JudgedCandidate, ...] = ()  # that the last look refused for their shape
    # alone, or because the held-out side does not go where they act
    bent_since: dict[Place, JudgedCandidate] = field(default_factory=dict)  # once they were refined
    followed: set[int] = field(default_factory=set)  # joints of which no spring held, and in which
    # nothing was found since
    gone: set[Place] = field(default_factory=set)  # from the model for good: springs, too
    sharpened: set[int] = field(default_factory=set)  # joints of which a sharper corner of dry
    # friction did what another friction would have
    progress: Callable[[float, str], None] = lambda share, text: None

    def run(self, steps: int | None = None) -> Search:
        """Add, prune, add again; once more without what turned out unsure in the end, and once with
        what left the model beside terms that may be gone since. steps: the most to add at a time;
        None: what an arm of so many joints may lack."""
        steps = self._most(steps)
        align(self.state)
        self.state = with_corners(self.state)
        refused: set[Place] = set()
        self._forward(steps, refused)
        if self._late_together():
            self._forward(steps, refused)
        doubted = self._without_unsure(steps, refused)
        if refused - doubted:
            refused = doubted
            self._forward(steps, refused)
            self._without_unsure(steps, refused)
        if self._exchanged():
            refused |= self.prune()
            self._forward(steps, refused)
            self._without_unsure(steps, refused)
        moved = [self._in_time(), self._behind_channel(), self._where_shared_slips()]
        if any(moved):
            self._forward(steps, refused)
            self._without_unsure(steps, refused)
        return self

    def go_on_without(self, gone: set[Place], steps: int | None = None) -> None:
        """Add and prune again once more, without what is gone from the model for good."""
        steps, refused = self._most(steps), {*gone}
        self.gone |= gone
        self._forward(steps, refused)
        self._without_unsure(steps, refused)

    def _most(self, steps: int | None) -> int:
        most = max(LEAST_STEPS, STEPS_PER_JOINT * self.state.train.n)
        return most if steps is None else steps

    def _where_shared_slips(self) -> bool:
        """Look at no moments any more in which what joints share sticks, now that it is known."""
        without = self.state.where_shared_slips()
        if without is self.state:
            return False
        self.state = without
        self.settle()
        self.prune()
        return True

    def _exchanged(self) -> bool:
        """Put in the place of findings those of their rivals, or other kinds of theirs, that are
        better by now."""
        if self.state.frozen:
            return False
        exchanged = False
        for step in self.steps:
            for rival in step.rivals:
                there = [(t.effect_id, t.joints) for t in self.state.terms]
                if step.chosen.place not in there[self.fixed :] or rival.place in there:
                    continue
                index = there.index(step.chosen.place, self.fixed)
                other = rather(self.state, index, rival, self.fixed)
                if other is not None:
                    self.state, exchanged = other, True
                    step.chosen = rival
                    step.rivals = [one for one in step.rivals if one is not rival]
        for index in range(self.fixed, len(self.state.terms)):
            if any(shape.optional for shape in self.state.terms[index].effect.shapes):
                other = of_another_kind(self.state, index, self.fixed)
                if other is not None:
                    self.state, exchanged = other, True
        return exchanged

    def _in_time(self) -> bool:
        """Take the robot's offset in time anew beside what was found, clear of knocks: what was
        missing when it was taken posed as some of it. A spring's damping is a delay of its torque,
        and took the rest; a knock that is foretold too early is one, too.
        """
        if len(self.state.terms) == self.fixed or not self.suspects:
            return False
        saved, moved = self.state.copy(), False
        for _ in range(TIMING_ROUNDS):
            (seen,) = clear_of_knocks(self.state)
            seconds = align(seen.copy(), shapes=True)
            if seconds == 0.0:
                break
            move(self.state, seconds)
            moved = True
            self.settle()
        before, after = clear_of_knocks(saved, self.state)
        if moved and spoils(before, after):
            self.state, moved = saved, False
        if moved:
            self.prune()
        return moved

    def _behind_channel(self) -> bool:
        """Let all columns pass what the torque has passed, where that shows by now; what stood in
        for it goes. One that identification saw is asked for anew beside what was found."""
        known = self.state.model.channel is not None
        if not self.suspects or (known and len(self.state.terms) == self.fixed):
            return False
        found = behind_channel(self.state)
        if found is not None:
            return self._gone_behind(found)
        found = beside_springs(self.state)
        return found is not None and self._gone_behind(found, agree_by_now)

    def _gone_behind(
        self,
        found: SearchState,
        agreed: Callable[[SearchState, SearchState], bool] = lambda before, after: True,
    ) -> bool:
        """Behind a channel, with shapes that follow it, unless that spoils something, or joints do
        not agree to it then."""
        saved, self.state = self.state.copy(), corners_anew(found)
        self.settle()
        for _ in range(TIMING_ROUNDS):  # shapes that follow it, and are followed by it
            better = tuned(self.state)
            if better is self.state:
                break
            self.state = corners_anew(better)
            self.settle()
        self.prune()
        was, now = clear_of_knocks(saved, self.state)
        spoilt = spoils(was, now, (made_held_out(was), made_held_out(now)))
        if spoilt or not agreed(saved, self.state):
            self.state = saved
            return False
        return True

    def _without_unsure(self, steps: int, refused: set[Place]) -> set[Place]:
        """Drop what is unsure and go on without it until all is sure; says what was not."""
        doubted: set[Place] = set()
        while unsure := self.unsure():
            doubted |= unsure
            refused |= unsure
            self._forward(steps, refused)
        return doubted

    def _late_together(self) -> bool:
        """Several joints "measured late" may be one offset of the whole robot, hidden as long as
        joints contradicted each other: take it instead of them, where it helps nearly all."""
        late = late_joints(self.state, self.fixed)
        if len(late) < 2:
            return False
        saved = self.state.copy()
        for index in reversed(late):
            self.state.drop(index)
        self.state.refit()
        if align(self.state, contradicting=True) == 0.0:
            self.state = saved
            return False
        self.settle()
        self.prune()
        return True

    def _forward(self, steps: int, refused: set[Place]) -> None:
        """refused: what was in the model and did not stay. What could not come in may yet do so
        beside what comes next: that may have been why."""
        put_off: set[Place] = set()
        self.followed.clear()
        added = 0
        while added < steps:
            self.progress(added / steps, f"step {added + 1}: looking through the library")
            good, judged = look(self._judging(self.suspects), refused | put_off)
            self.bent = tuple(j for j in judged if j.bent or j.unseen)
            before = rms(self.state.held_residual())
            spring = self.spring_beside(good)
            if spring is not None:
                refused |= self.prune() | self.reconsider()
                self.followed.clear()
                self.steps.append(Addition(*spring, before, rms(self.state.held_residual())))
                added, put_off = added + 1, set()
                continue
            if not good:
                pair = pair_beside(self._judging(self.suspects), judged, refused | put_off)
                if pair is None or added + len(pair.found) > steps:
                    break
                self.state = pair.state
                self.followed.clear()
                refused |= self.prune() | self.reconsider()
                after = rms(self.state.held_residual())
                for one, rivals in zip(pair.found, ([], pair.rivals), strict=True):
                    self.steps.append(Addition(one, rivals, before, after))
                added, put_off = added + len(pair.found), set()
                continue
            judging = self._judging(self.suspects)
            chosen, tied = prefer(self.state, good, judged)
            if absorbed := absorbed_rivals(judging, chosen, judged):
                good, judged = [*good, *absorbed], [*judged, *absorbed]
                chosen, tied = prefer(self.state, good, judged)
            if (corner := self._sharper_instead(chosen)) is not None:
                self.state = corner
                continue
            tied += bent_rivals(judging, chosen, judged)
            dropped = self.take(chosen)
            if dropped is None:
                put_off.add(chosen.place)
                continue
            if chosen.candidate.joints and not chosen.candidate.effect.seen_by_shared_bodies:
                self.followed -= {*chosen.candidate.joints}
            else:
                self.followed.clear()
            refused |= dropped | self.reconsider()
            self.steps.append(Addition(chosen, tied, before, rms(self.state.held_residual())))
            added, put_off = added + 1, set()

    def _sharper_instead(self, chosen: JudgedCandidate) -> SearchState | None:
        """Each joint once: a corner that has been moved is as the data have it."""
        kind, joints = chosen.candidate.effect, chosen.candidate.joints
        if not kind.carried or self.sharpened & {*joints}:
            return None
        found = as_unsure(self.state, joints, chosen.evidence.after, self.floor)
        if found is None and not kind.builds_up_over:
            found = sharper_instead(self.state, joints, chosen.evidence.after)
        if found is not None:
            self.sharpened |= {*joints}
        return found

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
        if not holds_clear(self._judging(self.suspects), chosen):
            return None
        saved = self.state.copy()
        left, turned = saved.problem.sigma, False
        for weights in (left, saved.fit.sigma if left is None else None):
            self.state = saved.copy()
            self.state.weigh(weights)
            self.state.push(chosen.candidate.term)
            self.settle()
            self._call_by_name()
            dropped = self.prune()
            if chosen.place in dropped or spoils(saved, self.state):
                continue
            if not turns_worse(saved, self.state):
                return dropped
            beside = self._with_companion(saved, chosen)
            if beside is not None:
                return dropped | beside
            turned = True
        told = self._as_reversals_have_it(saved, chosen) if turned else None
        if told is None:
            self.state = saved
        return told

    def _as_reversals_have_it(
        self, saved: SearchState, chosen: JudgedCandidate
    ) -> set[Place] | None:
        """What holds clear of reversals and makes them worse may have its peak there, of which
        that fit saw the foot alone: add it with the shape that they, too, agree with."""
        term = chosen.candidate.term
        if not told_by_reversals(term):
            return None
        self.state = saved.copy()
        self.state.heeding = saved.heeding | {chosen.place}
        self.state.push(term)
        self.settle()
        self._call_by_name()
        dropped = self.prune()
        return None if chosen.place in dropped or harmful(saved, self.state) else dropped

    def _call_by_name(self) -> None:
        """Terms that beside the newest one are another effect than they were found as: a contact
        that is touched everywhere is a spring."""
        for index in range(self.fixed, len(self.state.terms)):
            term = self.state.terms[index]
            judging = self._judging(self.suspects)
            itself = judging.is_itself(term.effect, term.joints, term.shape)
            if itself or not term.effect.otherwise:  # what has no other name does not stay
                continue
            other = effect(term.effect.otherwise)
            if any((t.effect_id, t.joints) == (other.id, term.joints) for t in self.state.terms):
                continue
            best = self.best(other, term.joints)
            shape = {} if best is None else best.shape
            start = np.zeros(len(other.coefficients))
            self.state.replace_term(index, Term(other.id, term.joints, start, shape))
            self.settle()

    def _with_companion(self, saved: SearchState, chosen: JudgedCandidate) -> set[Place] | None:
        """What holds in steady motion and makes only reversals worse may lack what happens there:
        friction that is higher at low speed, and builds up over a way. Add the best other effect of
        the same joint, if with both nothing is worse than before; says what became redundant."""
        there = [(e, joints) for e, joints in self.suspects if joints == chosen.candidate.joints]
        good, _ = look(self._judging(there))
        bare = self.state
        for best in sorted(good, key=lambda j: -j.gain):  # of one effect there may be two kinds
            self.state = bare.copy()
            self.state.push(best.candidate.term)
            self.settle()
            dropped = self.prune()
            if not (dropped & {chosen.place, best.place} or harmful(saved, self.state)):
                return dropped
        return None

    def spring_beside(
        self, good: Sequence[JudgedCandidate]
    ) -> tuple[JudgedCandidate, list[JudgedCandidate]] | None:
        """Add the spring that, with the bodies fitted behind it, takes more than any candidate does
        beside bodies that have bent to it; the other joint's where the data cannot tell."""
        most = max((j.candidate.gain for j in good), default=LEAST_GAIN)
        suspects = [(e, joints) for e, joints in self.suspects if (e.id, joints) not in self.gone]
        guessed = promising(self.state, suspects, most)
        if good:  # the rest comes first; in the end all are followed once more
            first = {g.joint for g in guessed[:SPRINGS_FOLLOWED]}
            fresh = [g for g in guessed if g.joint not in self.followed]
            guessed = [] if first <= self.followed else fresh
        states, followed = with_springs(self.state, suspects, guessed, self.floor)
        self.followed |= followed
        return self._best_of(states, most)

    def swinging(self, joints: Sequence[int]) -> bool:
        """Add the spring of the first of these joints whose link swings by itself, at its own mode
        and above all that the motion asks for, where nothing else of the library has helped."""
        before = rms(self.state.held_residual())
        for joint in joints[:SPRINGS_FOLLOWED]:
            spring = self._best_of(with_firm_spring(self.state, self.suspects, joint), LEAST_GAIN)
            if spring is not None:
                self.prune()
                self.reconsider()
                self.steps.append(Addition(*spring, before, rms(self.state.held_residual())))
                return True
        return False

    def _best_of(
        self, states: Sequence[SearchState], most: float
    ) -> tuple[JudgedCandidate, list[JudgedCandidate]] | None:
        """Go on with the first of these states, each with one term more, that holds and takes more
        than ``most``; what else does as well."""
        told = []
        for state in states:
            judged = Judging(state, self.suspects, self.fixed).term(len(state.terms) - 1)
            taken = taken_by(self.state, state)
            if judged.acceptable and taken > most and not harmful(self.state, state):
                told.append((state, judged, rms(state.held_residual())))
        if not told:
            return None
        self.state, chosen, left = told[0]
        for index in range(self.fixed):  # how sharp friction turns round was not to be seen before
            if self.state.terms[index].effect.smoothed_over:
                refine(self.state, self.fixed, index)
        tied = [j for _, j, r in told[1:] if np.all(r < (1.0 + MATERIAL_GAIN) * left)]
        return chosen, tied

    def best(self, effect: Effect, joints: tuple[int, ...]) -> Candidate | None:
        """The best shape of one effect in one place, or None where the data cannot show it."""
        found = scan(self.state, [(effect, joints)])
        return sharpened(self.state, found)[0] if found else None

    def rivals_of(self, index: int) -> list[JudgedCandidate]:
        """What explained the same error as a term equally well when it was chosen, does so yet
        beside all that was found since, and can be what it is called."""
        term = self.state.terms[index]
        place = term.effect_id, term.joints
        rivals = next((step.rivals for step in self.steps if step.chosen.place == place), [])
        rivals = [one for one in rivals if rival_yet(self.state, index, one, self.fixed)]
        if not rivals or term.effect.series_spring:  # of springs others bend the bodies as well
            return rivals
        bare = self.state.copy()
        bare.drop(index)
        bare.refit()
        asked = [(r.candidate.effect, r.candidate.joints) for r in rivals]
        return still_tied(
            Judging(bare, [(term.effect, term.joints), *asked], self.fixed), place, rivals
        )

    def contest(self) -> list[int]:
        """Joints on which the findings are beaten by a plain smooth map of the motion, of a gain by
        which the torque reads differently from place to place, by friction or an offset that
        changes at one moment, or by a dead band of the readings.

        A true effect explains its error better than any generic map can. Where a map alone
        leaves less than 1/OUTDONE of what the findings leave, they were only imitating something
        that the library does not have: they are dropped, and the joint is left unexplained.
        ``outdone`` has, by joint, what they are called and which share of its squared error they
        took.
        """
        concerned = sorted({j for t in self.state.terms[self.fixed :] for j in t.joints})
        if not concerned:
            return []
        bare = self.state.bare(self.fixed)
        now = self.state.held_residual()
        gains = list(all_maps(bare, concerned, "gain"))
        tried = chain(all_maps(bare, concerned), gains, all_maps(bare, concerned, "reading"))
        outdone = [maps[0].joint for maps in tried if any(m.outdoes(now, OUTDONE) for m in maps)]
        for step in steps_in_time(bare, [j for j in concerned if j not in outdone]):
            if OUTDONE * step.left**2 < rms(now)[step.joint] ** 2:
                outdone.append(step.joint)
        asked = [j for j in concerned if j not in outdone and j not in bare.held.silent]
        if not bare.frozen:
            self.dead_bands = dead_bands(bare, asked, rms(now), self.floor)
            outdone += self.dead_bands
        self.rival_gains = {
            m.joint: m
            for maps in gains
            for m in maps
            if m.joint not in outdone and m.outdoes(now, AS_WELL)
        }
        before, after = rms(bare.held_residual()), rms(now)
        for j in outdone:
            named = [t.effect.named for t in self.state.terms[self.fixed :] if j in t.joints]
            share = 1.0 - (after[j] / max(before[j], 1e-300)) ** 2
            self.outdone[j] = tuple(dict.fromkeys(named)), float(share)
        for index in reversed(range(self.fixed, len(self.state.terms))):
            if any(j in outdone for j in self.state.terms[index].joints):
                self.state.drop(index)
        if outdone:
            self.settle()
            self._drop_what_paid_for(outdone)
        return outdone

    def _drop_what_paid_for(self, unexplained: Sequence[int]) -> None:
        """What such joints leave draws the bodies towards itself, and others may have been given an
        effect that makes up for that: findings have to hold where they are not heard, too."""
        rest = without(self.state, unexplained)
        before = len(rest.terms)
        for index in reversed(range(self.fixed, len(rest.terms))):
            if not Judging(rest, self.suspects, self.fixed).term(index).acceptable:
                rest.drop(index)
                rest.refit()
                self.state.drop(index)
        if len(rest.terms) < before:
            self.settle()

    def settle(self, rounds: int = 2) -> None:
        """Refit, with loads and shapes of the new model."""
        self.state = settled(self.state, self.fixed, rounds)

    def prune(self) -> set[Place]:
        """Drop additions that later ones made redundant, the least useful first; says which. Beside
        a gap the others have to hold clear of its knocks, too: what those are off by asks for
        whatever bends to it."""
        dropped: set[Place] = set()
        while len(self.state.terms) > self.fixed:
            self._plainly()
            weakest = None
            (clear,) = clear_of_knocks(self.state)
            for index in range(self.fixed, len(self.state.terms)):
                judged = self.judge_term(index)
                if judged.acceptable and clear is not self.state and not blurred(clear, index):
                    judged = Judging(clear, self.suspects, self.fixed).term(index)
                if not judged.acceptable and (
                    weakest is None or judged.evidence.gain < weakest[1].evidence.gain
                ):
                    weakest = (index, judged)
            if weakest is None:
                break
            dropped.add(weakest[1].place)
            if weakest[1].bent:
                self.bent_since[weakest[1].place] = weakest[1]
            self.state.drop(weakest[0])
            self.state.refit()
        return dropped

    def _plainly(self) -> None:
        """Additions as the plain kind of their effect, where what theirs has besides has come to an
        end of what it may be, and that one can be what it is called: damped bristles whose damping
        is gone, as behind the channel that it stood in for."""
        for index in range(self.fixed, len(self.state.terms)):
            term = self.state.terms[index]
            optional = {shape.name for shape in term.effect.shapes if shape.optional}
            if not optional & term.shape.keys() or not term.effect.bent(term.shape):
                continue
            plain = {name: v for name, v in term.shape.items() if name not in optional}
            trial = self.state.copy()
            trial.replace_term(index, replace(term, shape=plain))
            trial.refit()
            refine(trial, self.fixed, index)
            judged = Judging(trial, self.suspects, self.fixed).term(index)
            most = (1.0 + MATERIAL_GAIN) * rms(self.state.held_residual())
            if judged.acceptable and np.all(rms(trial.held_residual()) <= most):
                self.state = trial

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

    def all_bent(self) -> list[JudgedCandidate]:
        """What would hold but for its shape, as it was looked for or once it was refined, and has
        not come back since."""
        there = {(t.effect_id, t.joints) for t in self.state.terms}
        since = [one for place, one in self.bent_since.items() if place not in there]
        return [*self.bent, *since]

    def judge_term(self, index: int) -> JudgedCandidate:
        """Held-out evidence of a term already in the model, on top of all others."""
        return self._judging(self.suspects).term(index)

    def _judging(self, suspects: Suspects) -> Judging:
        return Judging(self.state, suspects, self.fixed)
