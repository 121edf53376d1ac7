"""From a model and recordings to a diagnosis; adding an effect; going on until nothing is left."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.errors import Cancelled, UserError
from pa10d.common.parallel import one_thread
from pa10d.common.words import from_one
from pa10d.compare.above_band import lines_above_band
from pa10d.compare.knocks import knocks
from pa10d.compare.orders import order_spectrum
from pa10d.compare.places import places
from pa10d.diagnose.constants import MATERIAL_REST, SIZED_LEVEL
from pa10d.diagnose.outcome.diagnosis import Confusion, Diagnosis, Finding
from pa10d.diagnose.outcome.doubts import with_doubts
from pa10d.diagnose.outcome.next_experiment import settle_doubt
from pa10d.diagnose.outcome.words import reason, sentence
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.bent_laws import bent_laws
from pa10d.diagnose.search.candidates import Candidate, heard, suspects
from pa10d.diagnose.search.candidates import places as places_of
from pa10d.diagnose.search.corners import sharpened
from pa10d.diagnose.search.delivery import warnings as said
from pa10d.diagnose.search.frozen import (
    always_lacked,
    as_it_stood,
    held_firmly,
    kept_as_it_was,
    new_kinds,
)
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.judging import JudgedCandidate, Suspects
from pa10d.diagnose.search.noisy_angles import none_of_noise
from pa10d.diagnose.search.simpler import simpler_inside
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.versions import held_out, snapshot, unseen, versions_of
from pa10d.diagnose.search.whole import fitted_to_all
from pa10d.diagnose.search.with_numbers import (
    needed_beside_springs,
    needed_without_numbers,
    only_with_numbers,
)
from pa10d.diagnose.unknown.at_most import most_noise
from pa10d.diagnose.unknown.between_runs import Apart, contradiction, needless, unlike_fitted
from pa10d.diagnose.unknown.beyond import beyond
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.diagnose.unknown.geometry import Geometry, OtherGeometry, other_geometry
from pa10d.diagnose.unknown.left_over import left_over, unsaid
from pa10d.diagnose.unknown.of_joint import KnownBesides
from pa10d.diagnose.unknown.remaining import remaining
from pa10d.effects import Effect, Value, effect
from pa10d.judgement import (
    Judgement,
    in_band,
    judged,
    of_own_runs,
    repeatable,
    with_known_floor,
    with_one_floor,
)
from pa10d.judgement.scores import scores
from pa10d.measurement.recording import Recording
from pa10d.model import Term, TorqueModel
from pa10d.model.estimates import no_estimates, not_one
from pa10d.regression.noisy_limits import sharing_limits

Array = NDArray[np.float64]
NOT_ONE = (
    " Not one of its numbers is determined: that something acts like it is all that this data says."
)
NOT_BEYOND = "it lies inside, and what this effect has beyond it is zero by its own errors"
Progress = Callable[[float, str], None]


@one_thread()
def diagnose(
    model: TorqueModel,
    fit: Sequence[Recording],
    validate: Sequence[Recording] = (),
    *,
    frozen: bool = False,
    only: tuple[str, Sequence[int]] | None = None,
    steps: int | None = None,
    progress: Progress | None = None,
    cancel: Callable[[], bool] | None = None,
) -> Diagnosis:
    """Which effect is missing (or, frozen, what changed), judged on data the fit has not seen.

    only: (effect id, joints 0-based; empty: wherever it may sit) tests one suspicion.
    progress: called with (share done, what is being done); cancel: True raises ``Cancelled``.
    """

    reached = 0.0

    def say(share: float, what: str) -> None:
        nonlocal reached
        if cancel is not None and cancel():
            raise Cancelled("the diagnosis was cancelled")
        reached = max(reached, share)  # a search that goes on begins to count its steps anew
        if progress is not None:
            progress(reached, what)

    say(0.0, "filtering")
    before, model = model, in_band(model)
    known = of_own_runs([before], model.cutoff)
    fit, validate = _sharing_limits(fit, validate, model)
    train, held, words = two_sides(model, fit, validate)
    say(0.1, "fitting the given model")
    state = SearchState.start(model, train, held, frozen)
    given, moved = len(state.terms), rms(state.held_residual())
    as_given = held_out(model, state)
    given_error = with_known_floor(judged(model.name, as_given), known)
    asked = suspects(frozen, model.robot.n) if only is None else suspicion(only, model.robot.n)
    asked = heard(asked, held)
    if frozen:
        state = kept_as_it_was(state, model, given_error)
        asked = [one for one in asked if only or not always_lacked(*one, model, given_error)]
    search = Search(
        state,
        asked,
        given,
        given_error.floor.values,
        progress=lambda share, what: say(0.1 + 0.7 * share, what),
    )
    search.run(steps)
    more = steps is None or len(search.steps) < steps
    if not frozen and more and search.swinging(_keeps(given_error, search)):
        search.run(steps)
    if frozen and only is None:
        search.suspects = [*asked, *new_kinds(model, given_error, search)]
        if len(search.suspects) > len(asked):
            search.run(steps)
        only_with_numbers(search, model, as_given)
        search = held_firmly(search, model, as_given)
    if not frozen:
        needed_without_numbers(search, model, as_given)
        needed_beside_springs(search)
        none_of_noise(search, model, as_given)
    if only is None:
        search.contest()
    whole = only is None and not frozen
    apart = _between_runs(search, given, given_error) if whole else ()
    geometry = Geometry((), search.state)
    if whole and not apart:
        geometry = _geometry(search, given, given_error)
    state = search.state
    say(0.85, "looking for structure that the library does not know")
    versions = versions_of(model, state, given, as_given)
    views = [as_given, *(held_out(version, state) for version in versions)]
    seen = views[-1]
    known = of_own_runs([before, *versions], model.cutoff)
    least = with_one_floor([judged(versions[-1].name, view) for view in views])
    left = with_known_floor(least[-1], known)
    again = repeatable(seen)
    if only is None and not (apart or geometry.told):
        may_change = heard(suspects(True, model.robot.n), state.held)
        apart = unlike_fitted(state, given, may_change, left.floor.values)
    stood = as_it_stood(search, model, given_error, left, moved, None if only is None else asked)
    told: list[Apart | OtherGeometry] = [*apart, *geometry.told]
    over = left_over(
        state, seen, left, again, only is None, told, given, bent_laws(search.all_bent())
    )
    say(0.9, "standard errors and doubts")
    said_of = [u for u in over.unexplained if not isinstance(u, Unnamed)]
    open_ = unsaid(left, said_of) if only is None else []
    silent = [j for j in open_ if np.isfinite(left.ratio[j])]
    floor = left.floor.values
    stand_out = places(seen, model.robot, floor, joints=silent, clear=True) if open_ else ()
    turning = [j for j in open_ if not model.robot.prismatic[j]]
    orders = [order_spectrum(seen, j) if j in turning else None for j in range(model.robot.n)]
    findings = tuple(
        _finding(search, given, index, versions) for index in range(given, len(state.terms))
    )
    knocked = {j: found for j in open_ if (found := knocks(seen, j)) is not None}
    faster = lines_above_band(orders, left.cutoff, left.rms)
    first = as_given if frozen else views[1]
    verdict = "missing" if findings else "unknown" if over.unexplained else "none"
    kept = versions[1:] if frozen else fitted_to_all(model, versions[1:], fit, held.runs)
    lines = remaining(
        left,
        again,
        over.unexplained,
        [model.robot.torque_unit(j) for j in range(model.robot.n)],
        KnownBesides(
            found=state.terms[given:],
            searched=only is None,
            slight=over.slight,
            doubt=over.doubt,
            beyond=beyond(state),
            gains={**search.rival_gains, **over.gains},
            stand_out=stand_out,
            silent=held.silent,
            undetermined=over.undetermined,
            faster=faster,
            beside=over.beside,
            knocked={j: found.words for j, found in knocked.items()},
            outdone=search.outdone,
            most_noise=most_noise(state),
            usual=state.usual,
            lacked=model.noise,
            as_given=state.as_given,
            moved=np.flatnonzero(stood.far).tolist(),
            alone=stood.alone,
        ),
    )
    say(1.0, "done")
    return Diagnosis(
        verdict=verdict,  # type: ignore[arg-type]
        rms=given_error.rms if frozen else versions[0].held_out["held out"],
        as_given=given_error,
        left=left,
        cutoff=model.cutoff,
        findings=with_doubts(findings, state, given, lines, over.unexplained, geometry),
        unexplained=over.unexplained,
        remaining=lines,
        model=versions[-1],
        versions=versions,
        stored=tuple(kept),
        fitted=tuple(state.train.runs),
        held_out=tuple(state.held.runs),
        judged_on=words,
        frozen=frozen,
        identified_from=model.runs,
        with_reversals=scores(first).rms_with_reversals,
        above_band=faster,
        knocked=tuple(knocked),
        only="" if only is None else effect(only[0]).named,
        lacked=tuple(
            j
            for j in range(model.robot.n)
            if state.usual is not None and left.rms[j] <= state.usual[j] and not stood.far[j]
        ),
        stood=stood.words,
        told=_told(model),
        sharper=sharpened(model, state) if frozen else {},
        passed=str(state.model.channel) if state.model.channel != model.channel else "",
    )


@one_thread()
def add(
    model: TorqueModel,
    effect_id: str,
    joints: Sequence[int],
    fit: Sequence[Recording],
    *,
    name: str,
    validate: Sequence[Recording] = (),
    progress: Progress | None = None,
) -> tuple[TorqueModel, list[str]]:
    """A new version with one effect fitted in, on each of the given joints (0-based; a pair for
    effects of pairs), and warnings where it is not significant or identifiable."""
    say = progress or (lambda share, what: None)
    say(0.0, "filtering")
    suspects = lacking(model, effect_id, joints)
    model = in_band(model)
    fit, validate = _sharing_limits(fit, validate, model)
    train, held, _ = two_sides(model, fit, validate)
    state = SearchState.start(model, train, held)
    as_given = held_out(model, state)
    given = len(state.terms)
    search = Search(state, suspects, given)
    warnings = []
    for number, (kind, place) in enumerate(search.suspects):
        say(0.2 + 0.6 * number / len(search.suspects), f"fitting {effect_id}")
        best = search.best(kind, place)
        if best is None:
            warnings.append(
                f"{_label(kind, place)}: this data cannot tell it from what the model has; "
                "it was left out"
            )
            continue
        search.state.push(best.term)  # the search may have gone on with a copy
        search.settle(rounds=1)
    state = search.state
    if len(state.terms) == given:
        raise UserError(
            f"{effect_id}: cannot be told from the model's own terms on this data; "
            f"expected data that shows it: {effect(effect_id).experiment}"
        )
    for index in range(given, len(state.terms)):
        judged = search.judge_term(index)
        if not judged.acceptable:
            warnings.append(
                f"{state.terms[index].label}: not significant on held-out data "
                f"(p = {judged.p_corrected:.2g}, slope {judged.evidence.slope:.2f})"
            )
    say(1.0, "done")
    added = ", ".join(t.label for t in state.terms[given:])
    made = snapshot(model, state, len(state.terms), as_given)
    warnings += unseen(made, state, given).values()
    (made,) = fitted_to_all(model, [made], fit, held.runs)
    warnings += said(made)
    return replace(made, name=name, change=f"added {added}"), warnings


def suspicion(only: tuple[str, Sequence[int]], n: int) -> Suspects:
    """One effect on the given joints (0-based) of ``n``, or wherever it may sit."""
    kind, joints = effect(only[0]), list(only[1])
    if kind.question == "chosen":
        raise UserError(f"{kind.id}: explains nothing, so it is no suspect; expected an effect")
    for j in joints:
        if not 0 <= j < n:
            raise UserError(f"joint {j + 1}: expected {from_one(n)}")
    if kind.scope == "robot" or not joints:
        return [(kind, place) for place in places_of(kind, n)]
    if kind.scope == "pair":
        if len(joints) != 2 or joints[0] == joints[1]:
            raise UserError(f"{kind.id}: acts on a pair, expected two different joints")
        return [(kind, (min(joints), max(joints)))]
    return [(kind, (j,)) for j in joints]


def lacking(model: TorqueModel, effect_id: str, joints: Sequence[int]) -> Suspects:
    """Where the effect can be added: a second one of the same columns would take its torque from
    the first. joints: 0-based; empty: wherever the model has none yet. UserError where it has it.
    """
    asked = suspicion((effect_id, joints), model.robot.n)
    present = {(t.effect_id, t.joints) for t in model.terms}
    once = [(kind, at) for kind, at in asked if not (kind.repeatable or kind.one_of_each)]
    there = [one for one in once if (one[0].id, one[1]) in present]
    if there and (joints or len(there) == len(asked)):
        named = ", ".join(_label(kind, at) for kind, at in there)
        raise UserError(
            f"{named}: model '{model.name}' has it already; expected an effect that it lacks there"
        )
    return [one for one in asked if one not in there]


def _sharing_limits(
    fit: Sequence[Recording], held_out: Sequence[Recording], model: TorqueModel
) -> tuple[list[Recording], list[Recording]]:
    """Both sides are of one arm: what ends a torque in one ends it in the other."""
    both = sharing_limits([*fit, *held_out], model.robot, model.notes.torque_ends)
    return both[: len(fit)], both[len(fit) :]


def _told(model: TorqueModel) -> tuple[str, ...]:
    """Of which parameters somebody knew something when the model was identified."""
    prior = model.notes.prior
    if prior is None:
        return ()
    names = tuple(one.name for one in prior.given)
    return names if prior.percent is None else ("all bodies", *names)


def _between_runs(search: Search, given: int, as_given: Judgement) -> tuple[Apart, ...]:
    """What fitted runs contradict each other in; findings that only stood in for it are dropped."""
    floor = as_given.floor.values
    may_change = heard(suspects(True, search.state.train.n), search.state.held)
    rest = needless(search.state, may_change, given, floor)
    if rest is not search.state:
        search.state = rest
        search.settle()
    return contradiction(search.state, may_change, floor).told


def _geometry(search: Search, given: int, as_given: Judgement) -> Geometry:
    """Whether lengths or axes are not as the URDF says; findings that only stood in for that are
    dropped."""
    likewise = [(e, j) for e, j in search.suspects if e.seen_by_shared_bodies]
    found = other_geometry(search.state, likewise, given, as_given.floor.values)
    if found.state is not search.state:
        search.state = found.state
        search.settle()
    return found


def _keeps(given: Judgement, search: Search) -> list[int]:
    """Joints that keep materially more than their noise, those that keep most of it first."""
    ratio = rms(search.state.held_residual()) / given.floor.values
    return [int(j) for j in np.argsort(-ratio) if ratio[j] > MATERIAL_REST]


def _finding(search: Search, given: int, index: int, versions: Sequence[TorqueModel]) -> Finding:
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
            sized(versions[-1], index) and _size_told(term, parameters),
            (_without(state, index, judged.evidence.before), judged.evidence.after),
        )
        + (none and f" But {none}.")
        + (NOT_ONE if not_one(term, parameters) else ""),
        certain=judged.certain,
    )


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


def _size_told(term: Term, parameters: Mapping[str, Value]) -> bool:
    """Is one of its sizes an estimate, or all that there is to say in its shape?"""
    told = [parameters[c.name] for c in term.effect.coefficients if c.name in parameters]
    return not told or any(value.determined or value.beyond for value in told)


def _size(state: SearchState, index: int, judged: JudgedCandidate) -> Value:
    """RMS of the torque where it acts most; its error follows from the held-out slope."""
    columns = state.blocks[index][1]
    torque = {j: c @ state.terms[index].coefficients for j, c in columns.items()}
    acted = {j: float(np.sqrt(np.mean(v**2))) for j, v in torque.items()}
    where = max(acted, key=lambda j: acted[j])
    largest = acted[where]
    z = max(abs(judged.evidence.z), 1e-9)
    return Value(
        largest, largest * abs(judged.evidence.slope) / z, state.model.robot.torque_unit(where)
    )


def _confusion(term: Term, other: Candidate) -> Confusion:
    return Confusion(other.effect.id, other.joints, reason(term.effect, other.effect))


def _label(kind: Effect, joints: Sequence[int]) -> str:
    return f"{kind.id} J{','.join(str(j + 1) for j in joints)}" if joints else kind.id
