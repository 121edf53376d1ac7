"""Two effects of one joint of which neither holds alone.

A law with a shape of its own bends to what else the joint lacks. Friction that is higher at low
speed, and friction that grows faster than the speed, each take the other's part as far as their
shapes go, and end where they are no longer what they are called. With the other one beside it,
each is itself.

What shows only in how joints contradict each other (a gain that is off) takes much of the fit side,
bodies and all, and what else that joint lacks decides what it does to motion held out. Beside that
it holds, and so does the other.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass

from pa10d.diagnose.constants import (
    LEAST_GAIN,
    MATERIAL_GAIN,
    PER_JOINT,
    SEARCH_LEVEL,
    SHARED_PAIRS,
)
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.candidates import scan
from pa10d.diagnose.search.harm import harmful, rms, taken_by
from pa10d.diagnose.search.judging import JudgedCandidate, Judging, Place
from pa10d.diagnose.search.looking import look, prefer
from pa10d.diagnose.search.refitting import settled, what_is_left


@dataclass
class Pair:
    """state: the model with both added last, settled; found: both, the first one first, as they are
    judged beside each other; rivals: what explains the second's part as well."""

    state: SearchState
    found: tuple[JudgedCandidate, JudgedCandidate]
    rivals: list[JudgedCandidate]


def pair_beside(
    judging: Judging, judged: Sequence[JudgedCandidate], refused: Container[Place] = ()
) -> Pair | None:
    """The best two effects of one joint that hold beside each other, where one that would hold
    alone goes to the end of its range, or shows in shared bodies and does not hold; None where
    there is no such joint.

    judged: what was judged alone. Both together must leave less than either does alone, on both
    sides, and each must hold on top of the other, corrected for the pairs that were tried.
    """
    if judging.state.frozen:
        return None
    asked = [j for j in judged if j.place not in refused and _of_one_joint(j)]
    firsts = [j for j in asked if j.bent]
    shared = [j for j in asked if j.candidate.effect.seen_by_shared_bodies and not j.acceptable]
    shared = [j for j in shared if j.candidate.gain >= LEAST_GAIN]
    firsts += sorted(shared, key=lambda j: -j.candidate.gain)[:SHARED_PAIRS]
    pairs = [pair for one in firsts for pair in _pairs(judging, one, firsts, refused)]
    return min(pairs, key=lambda p: what_is_left(p.state), default=None)


def _of_one_joint(one: JudgedCandidate) -> bool:
    return len(one.candidate.joints) == 1 and not one.candidate.effect.reaches_other_joints


def _pairs(
    judging: Judging,
    first: JudgedCandidate,
    firsts: Sequence[JudgedCandidate],
    refused: Container[Place],
) -> Iterator[Pair]:
    """The first one where it is still itself, with each that holds beside it."""
    kind, joints = first.candidate.effect, first.candidate.joints
    inside = [c for c in scan(judging.state, [(kind, joints)]) if not kind.bent(c.shape)]
    if not inside:
        return
    begun = judging.state.copy()
    begun.push(inside[0].term)
    begun.refit()
    there = [(e, at) for e, at in judging.suspects if at == joints]
    good, beside = look(Judging(begun, there, judging.fixed), refused)
    for second in sorted(good, key=lambda j: -j.gain)[:PER_JOINT]:
        state = begun.copy()
        state.push(second.candidate.term)
        state = settled(state, judging.fixed)
        both = Judging(state, judging.suspects, judging.fixed)
        last = len(state.terms) - 1
        found = both.term(last - 1), both.term(last)
        rivals = [r for r in prefer(begun, [second], beside)[1] if r.place != first.place]
        if _hold(judging.state, state, found, firsts):
            yield Pair(state, found, rivals)


def _hold(
    before: SearchState,
    after: SearchState,
    found: Sequence[JudgedCandidate],
    firsts: Sequence[JudgedCandidate],
) -> bool:
    """Each on top of the other, both of them better than any alone, and nothing worse."""
    (joint,) = found[0].candidate.joints
    alone = [j for j in firsts if j.candidate.joints == (joint,)]
    left = min(float(j.evidence.after[joint]) for j in alone)
    taken = max(j.candidate.gain for j in alone)
    return (
        all(j.acceptable and j.p_corrected * len(firsts) < SEARCH_LEVEL for j in found)
        and rms(after.held_residual())[joint] < (1.0 - MATERIAL_GAIN) * left
        and taken_by(before, after) > taken + LEAST_GAIN
        and not harmful(before, after)
    )
