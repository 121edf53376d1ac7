"""What a model may lack: all suspects scanned, the strongest of every joint judged.

Several of a joint's strongest may be one direction by several names (an offset, an asymmetry, a
spring, a contact), and none of them hold on the held-out side; what does may come behind them. So
whoever finds none good asks for the next ones.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import replace

import numpy as np

from pa10d.diagnose.constants import (
    LEAST_GAIN,
    MATERIAL_GAIN,
    PER_JOINT,
    ROUNDED,
    SAME_DIRECTION,
    SHORTLIST,
    TELL_APART,
)
from pa10d.diagnose.evidence.errors_of import ModelUncertainties
from pa10d.diagnose.evidence.held_out import rivalry
from pa10d.diagnose.regression.clear_of_knocks import clear_of_knocks
from pa10d.diagnose.regression.partial import partials
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.candidates import Candidate, scan, sharpened, started
from pa10d.diagnose.search.judging import (
    JudgedCandidate,
    Judging,
    Place,
    Suspects,
    seen_change,
)


def look(
    judging: Judging, refused: Container[Place] = ()
) -> tuple[list[JudgedCandidate], list[JudgedCandidate]]:
    """Scan all suspects and judge shortlists on the held-out side until one holds, but for what is
    refused → those that hold, and all that were judged."""
    judged: list[JudgedCandidate] = []
    for found in _shortlists(scan(judging.state, _open(judging))):
        judged += _judged(judging, found, len(judged) + len(found))
        if good := [j for j in judged if j.acceptable and j.place not in refused]:
            return good, judged
    return [], judged


def _open(judging: Judging) -> Suspects:
    state = judging.state
    # of a model that stays as it is, what it has already may have changed
    first = judging.fixed if state.frozen else 0
    present = {(t.effect_id, t.joints) for t in state.terms[first:]}
    return [
        (e, joints)
        for e, joints in judging.suspects
        if (e.id, joints) not in present or e.repeatable or e.one_of_each
    ]


def _judged(judging: Judging, found: list[Candidate], among: int) -> list[JudgedCandidate]:
    return evidence_of(judging, sharpened(judging.state, found), among)


def evidence_of(judging: Judging, sharp: Sequence[Candidate], among: int) -> list[JudgedCandidate]:
    """Candidates as they are, on the held-out side."""
    state = judging.state
    columns = [state.train.columns(c.effect, c.joints, [c.shape]) for c in sharp]
    seen = [seen_change(state.fit, k, c) for k, c in zip(columns, sharp, strict=True)]
    own = [{j: s[j] for j in k} for k, s in zip(columns, seen, strict=True)]
    doubts = ModelUncertainties.of(state, own)
    return [
        judging.candidate(c, among, s, doubts.beside(o))
        for c, s, o in zip(sharp, seen, own, strict=True)
    ]


def holds_clear(judging: Judging, chosen: JudgedCandidate) -> bool:
    """Does it hold clear of knocks, too, with a shape that suits there? What those are off by asks
    for whatever bends to it; a gap is its knocks."""
    (clear,) = clear_of_knocks(judging.state)
    kind, joints, shape = (
        chosen.candidate.effect,
        chosen.candidate.joints,
        chosen.candidate.shape,
    )
    if clear is judging.state or any(s.blur for s in kind.shapes):
        return True
    columns = clear.train.columns(kind, joints, [shape])
    falls, width = clear.may_fall(kind), len(kind.coefficients)
    there = partials(clear.fit, columns, kind, width, falls=falls)[0]
    sharp = sharpened(clear, [replace(chosen.candidate, partial=there)])
    asked = Judging(clear, judging.suspects, judging.fixed)
    return evidence_of(asked, sharp, SHORTLIST)[0].acceptable


def bent_rivals(
    judging: Judging, chosen: JudgedCandidate, judged: Sequence[JudgedCandidate]
) -> list[JudgedCandidate]:
    """What the chosen one is known to be taken for, on the same joints, where the fit side drew
    that to the end of its range: as it is inside of it, if it explains the held-out side as well.
    What else the joint lacks may have drawn it there."""
    state, kind = judging.state, chosen.candidate.effect
    out = []
    for one in judged:
        other, joints, shape = one.candidate.effect, one.candidate.joints, one.candidate.shape
        if other.id not in kind.confounders or joints != chosen.candidate.joints:
            continue
        if not other.bent(shape):
            continue
        inside = [c for c in started(state, other, joints) if not other.bent(c.shape)]
        tried = evidence_of(judging, inside, len(judged) + len(inside)) if inside else []
        alike = [j for j in tried if _tied(state, chosen, j)]
        out += sorted(alike, key=lambda j: -j.gain)[:1]
    return out


def absorbed_rivals(
    judging: Judging, chosen: JudgedCandidate, judged: Sequence[JudgedCandidate]
) -> list[JudgedCandidate]:
    """What the chosen one is known to be taken for, on the same joints, of which the model takes up
    so much that it is no candidate: what is left of it may be all that there is to see. A spring
    against gravity leaves its bend alone, and a contact has one, too."""
    state, kind = judging.state, chosen.candidate.effect
    there = {one.place for one in judged}
    out = []
    for other, joints in judging.suspects:
        asked = other.id in kind.confounders and joints == chosen.candidate.joints
        if not asked or (other.id, joints) in there or other.reaches_other_joints:
            continue
        inside = [c for c in started(state, other, joints, ROUNDED) if not other.bent(c.shape)]
        tried = evidence_of(judging, inside, len(judged) + len(inside)) if inside else []
        alike = [j for j in tried if j.acceptable and _tied(state, chosen, j)]
        out += sorted(alike, key=lambda j: -j.gain)[:1]
    return out


def prefer(
    state: SearchState, good: list[JudgedCandidate], judged: list[JudgedCandidate]
) -> tuple[JudgedCandidate, list[JudgedCandidate]]:
    """The best candidate, or the simplest of those that this data cannot tell from it."""
    best = max(good, key=lambda j: j.gain)
    tied = [j for j in judged if j is best or _tied(state, best, j)]
    chosen = min((j for j in tied if j in good), key=lambda j: (j.complexity, -j.gain))
    return chosen, [j for j in tied if j.place != chosen.place]


def still_tied(
    judging: Judging, place: Place, rivals: Sequence[JudgedCandidate]
) -> list[JudgedCandidate]:
    """Those of a term's rivals that this data cannot tell from it beside all that the state has;
    the term itself is out of it."""
    _, judged = look(judging)
    own = next((j for j in judged if j.place == place), None)
    if own is None:
        return list(rivals)
    apart = {j.place for j in judged if j is not own and not _tied(judging.state, own, j)}
    return [r for r in rivals if r.place not in apart]


def _shortlists(found: list[Candidate]) -> Iterator[list[Candidate]]:
    """One after the other, until the fit side speaks for none that is left."""
    while first := _shortlist(found):
        yield first
        taken = {id(c) for c in first}
        found = [c for c in found if id(c) not in taken]


def _shortlist(found: list[Candidate]) -> list[Candidate]:
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


def _tied(state: SearchState, best: JudgedCandidate, other: JudgedCandidate) -> bool:
    """By what they change where either of them speaks: what they shift elsewhere is the same
    for both but for chance, and where another joint still lacks something that is much."""
    if _says_more(state, best, other):
        return True
    residual = state.held_residual()
    every = np.arange(state.held.n)
    spoken = {int(j) for one in (best, other) for j in every[one.speaks_on]}
    a, b = ({j: c for j, c in one.change.items() if j in spoken} for one in (best, other))
    overlap, z = rivalry(state.held, residual, a, b)
    alike = np.all(other.evidence.after < (1.0 + MATERIAL_GAIN) * best.evidence.after)
    return overlap > SAME_DIRECTION and (z < TELL_APART or bool(alike))


def _says_more(state: SearchState, best: JudgedCandidate, other: JudgedCandidate) -> bool:
    """Does one that was not sure enough explain more than the best, and leave less where that one
    is? What it moves elsewhere may be why it was not sure."""
    own = list(best.candidate.joints or range(state.held.n))
    elsewhere = {*other.candidate.joints} != {*best.candidate.joints}
    less = np.all(other.evidence.after[own] < best.evidence.after[own])
    whole = other.is_itself and other.acts and not other.evidence.worse
    return bool(elsewhere and whole and other.gain > best.gain and less)
