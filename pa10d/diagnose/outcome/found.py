"""What a search found, as a finding: its numbers, its rivals, what would settle them, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.words import listed
from pa10d.diagnose.constants import SIZED_LEVEL
from pa10d.diagnose.outcome.diagnosis import Confusion, Finding
from pa10d.diagnose.outcome.next_experiment import settle_doubt
from pa10d.diagnose.outcome.words import reason, sentence
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.candidates import Candidate
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.judging import JudgedCandidate
from pa10d.diagnose.search.rivals import kinds_untold
from pa10d.diagnose.search.simpler import simpler_inside
from pa10d.diagnose.search.steps import Search
from pa10d.effects import Value
from pa10d.model import Term, TorqueModel
from pa10d.model.estimates import no_estimates, not_one

Array = NDArray[np.float64]
NOT_ONE = (
    " Not one of its numbers is determined: that something acts like it is all that this data says."
)
KIND = " Whether it is {one} or {other}, this data does not tell; {other}, {numbers}."
NOT_BEYOND = "it lies inside, and what this effect has beyond it is zero by its own errors"


def finding(search: Search, given: int, index: int, versions: Sequence[TorqueModel]) -> Finding:
    """Of the term ``index``, of which the first ``given`` stood in the model before."""
    state = search.state
    term = state.terms[index]
    judged = search.judge_term(index)
    before = versions[index - given].held_out["held out"]
    if state.as_given is not None and index == given:
        before = state.as_given  # not as it was moved to do without
    after = versions[index - given + 1].held_out["held out"]
    size = _size(state, index, judged)
    rivals = [r.candidate for r in search.rivals_of(index)]
    confusions = tuple(_confusion(term, r) for r in rivals)
    places_named = {(r.effect.id, r.joints) for r in rivals}
    simpler = [
        r
        for r in simpler_inside(search, index, versions[-1])
        if (r.effect.id, r.joints) not in places_named
    ]
    confusions += tuple(Confusion(r.effect.id, r.joints, NOT_BEYOND) for r in simpler)
    rivals += simpler
    named = {j for t in state.terms if t.effect_id == term.effect_id for j in t.joints}
    others = [j for j in range(state.model.robot.n) if j not in named]
    parameters = versions[-1].term_values(index)
    none = no_estimates(term, parameters)
    plan = None
    if rivals:
        own = Candidate(term.effect, term.joints, term.shape, judged.candidate.partial)
        plan = settle_doubt(state.model, own, rivals)
    return Finding(
        term=versions[-1].terms[index],
        parameters=parameters,
        rms_before=before,
        rms_after=after,
        p_value=judged.p_corrected,
        slope=judged.evidence.slope,
        size=size,
        confounded_with=confusions,
        next_experiment=plan,
        sentence=sentence(
            term,
            before,
            after,
            size,
            confusions,
            state.frozen,
            others,
            _size_told(term, parameters, sized(versions[-1], index)),
            (_without(state, index, judged.evidence.before), judged.evidence.after),
        )
        + (none and f" But {none}.")
        + (NOT_ONE if not_one(term, parameters) else "")
        + _of_kinds(term, kinds_untold(state, index, search.fixed)),
        certain=judged.certain,
    )


def _of_kinds(term: Term, others: Sequence[Term]) -> str:
    """What choices mean that this data cannot tell from those that were made, and what numbers
    belong to them: an error of either kind knows nothing of the other. Nothing where they have no
    words."""
    said = ""
    for other in others:
        for choice in (s for s in term.effect.shapes if s.says):
            one, two = (choice.says.get(t.shape.get(choice.name, 0.0)) for t in (term, other))
            if one and two and one != two:
                said += KIND.format(one=one, other=two, numbers=_would_be(other))
    return said


def _would_be(term: Term) -> str:
    """Its coefficients, "Td would be 0.0203 s"."""
    pairs = zip(term.effect.coefficients, term.coefficients, strict=True)
    return listed([f"{c.name} would be {value:.3g} {c.unit}" for c, value in pairs])


def _without(state: SearchState, index: int, before: Array) -> Array:
    """(n,) N·m RMS that all other findings leave held out; before: the same with nothing in its
    place. Dry friction that bristles carry turns round at once without them."""
    if not state.terms[index].effect.builds_up_over:
        return before
    rest = state.copy()
    rest.drop(index)
    rest.refit()
    return rms(rest.held_residual())


def sized(model: TorqueModel, index: int) -> bool:
    """Are a term's coefficients together other than zero by their own errors (Wald)?"""
    where = model.term_slice(index)
    values, covariance = model.terms[index].coefficients, model.covariance[where, where]
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    apart = values / scale
    turned = np.linalg.pinv(covariance / np.outer(scale, scale), hermitian=True)
    return bool(apart @ turned @ apart > scipy.special.chdtri(len(values), SIZED_LEVEL))


def _size_told(term: Term, parameters: Mapping[str, Value], other_than_zero: bool) -> bool:
    """Is one of its sizes an estimate? other_than_zero: its coefficients, by their own errors. The
    size of what has a share of its law alone, as gaps and springs have, is in its shape."""
    told = [c for c in term.effect.coefficients if c.name in parameters]
    if told and all(c.whole_at_one for c in told):
        sizes = (s for s in term.effect.shapes if not s.smoothing and s.scale != "choice")
        if any(parameters[s.name].determined for s in sizes if s.name in parameters):
            return True
    known = [parameters[c.name] for c in told]
    return other_than_zero and (not known or any(v.determined or v.beyond for v in known))


def _size(state: SearchState, index: int, judged: JudgedCandidate) -> Value:
    """RMS of the torque where it acts most; its error follows from the held-out slope, and from the
    torque constant's, as that of every other figure."""
    columns = state.blocks[index][1]
    torque = {j: c @ state.terms[index].coefficients for j, c in columns.items()}
    acted = {j: float(np.sqrt(np.mean(v**2))) for j, v in torque.items()}
    where = max(acted, key=lambda j: acted[j])
    largest = acted[where]
    z = max(abs(judged.evidence.z), 1e-9)
    robot, error = state.model.robot, largest * abs(judged.evidence.slope) / z
    known = Value(largest, error, robot.torque_unit(where))
    return known.with_gain_error(robot.gain_share((where,)))


def _confusion(term: Term, other: Candidate) -> Confusion:
    return Confusion(other.effect.id, other.joints, reason(term.effect, other.effect))
