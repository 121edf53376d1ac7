"""From a model and recordings to a diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from pa10d.common.errors import Cancelled
from pa10d.common.parallel import one_thread
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.diagnose.outcome.doubts import with_doubts
from pa10d.diagnose.outcome.found import finding
from pa10d.diagnose.outcome.held import held_at_none
from pa10d.diagnose.outcome.rest import rest_of
from pa10d.diagnose.search.begun import Begun, begin
from pa10d.diagnose.search.bent_laws import bent_laws
from pa10d.diagnose.search.candidates import absorbed
from pa10d.diagnose.search.channel import channel_words
from pa10d.diagnose.search.corners import sharpened
from pa10d.diagnose.search.course import Only, searched
from pa10d.diagnose.search.finished import Finished, finished
from pa10d.diagnose.search.frozen import as_it_stood
from pa10d.diagnose.search.none_at_least import or_none_at_least
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.stood_in import NoEffects, no_effects, not_asked
from pa10d.diagnose.search.suspects import heard, suspects
from pa10d.diagnose.search.whole import fitted_to_all
from pa10d.diagnose.unknown.between_runs import Apart, unlike_fitted
from pa10d.diagnose.unknown.left_over import left_over
from pa10d.effects import effect
from pa10d.judgement.scores import scores
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel

Progress = Callable[[float, str], None]


@one_thread()
def diagnose(
    model: TorqueModel,
    fit: Sequence[Recording],
    validate: Sequence[Recording] = (),
    *,
    frozen: bool = False,
    only: Only | None = None,
    steps: int | None = None,
    progress: Progress | None = None,
    cancel: Callable[[], bool] | None = None,
) -> Diagnosis:
    """Which effect is missing (or, frozen, what changed), judged on data the fit has not seen.

    only: (effect id, joints 0-based; empty: wherever it may sit) tests one suspicion.
    progress: called with (share done, what is being done); cancel: True raises ``Cancelled``.
    """
    say = _saying(progress, cancel)
    say(0.0, "filtering, fitting the given model")
    begun = begin(model, fit, validate, frozen)

    def looked(one: Begun) -> Search:
        return searched(one, only, steps, lambda share, what: say(0.1 + 0.7 * share, what))

    search = looked(begun)
    begun, search = or_none_at_least(
        begun, search, lambda: begin(begun.whole, fit, validate, none_at_least=True), looked
    )
    no_effect = no_effects(search, begun) if only is None else not_asked(search)
    say(0.85, "looking for structure that the library does not know")
    end = finished(begun, search.state)
    if only is None and not no_effect.told:
        no_effect = replace(no_effect, apart=_unlike_fitted(begun, search, end))
    return _told(begun, search, no_effect, end, only, say)


def _saying(progress: Progress | None, cancel: Callable[[], bool] | None) -> Progress:
    """A progress that never goes back, and ends with ``Cancelled`` where that is asked for."""
    reached = 0.0

    def say(share: float, what: str) -> None:
        nonlocal reached
        if cancel is not None and cancel():
            raise Cancelled("the diagnosis was cancelled")
        reached = max(reached, share)  # a search that goes on begins to count its steps anew
        if progress is not None:
            progress(reached, what)

    return say


def _unlike_fitted(begun: Begun, search: Search, end: Finished) -> tuple[Apart, ...]:
    may_change = heard(suspects(True, begun.model.robot.n), search.state.held)
    return unlike_fitted(search.state, begun.given, may_change, end.left.floor.values)


def _told(
    begun: Begun,
    search: Search,
    no_effect: NoEffects,
    end: Finished,
    only: Only | None,
    say: Progress,
) -> Diagnosis:
    """All that was found, and what is left after it, together."""
    model, state, given = begun.model, search.state, begun.given
    frozen, held, whole = state.frozen, state.held, only is None
    smoothed = state.model.channel != model.channel
    asked = None if whole else search.suspects
    stood = as_it_stood(search, model, begun.error, end.left, begun.moved, asked)
    bent = bent_laws(search.all_bent())
    over = left_over(state, end.seen, end.left, end.again, whole, no_effect.told, given, bent)
    say(0.9, "standard errors and doubts")
    rest = rest_of(begun, search, end, over, stood, whole)
    findings = [
        finding(search, given, index, end.versions) for index in range(given, len(state.terms))
    ]
    verdict = "missing" if findings else "unknown" if over.unexplained else "none"
    later = end.versions[1:]
    runs = begun.fit, held.everywhere.runs
    stored = later if frozen else fitted_to_all(model, later, *runs, state.none_at_least)
    say(1.0, "done")
    return Diagnosis(
        verdict=verdict,  # type: ignore[arg-type]
        rms=begun.error.rms if frozen else end.versions[0].held_out["held out"],
        as_given=begun.error,
        left=end.left,
        cutoff=model.cutoff,
        findings=with_doubts(
            findings, state, given, rest.lines, over.unexplained, no_effect.geometry
        ),
        unexplained=over.unexplained,
        remaining=rest.lines,
        model=end.versions[-1],
        versions=end.versions,
        stored=tuple(stored),
        fitted=tuple(state.train.runs),
        held_out=tuple(held.runs),
        judged_on=begun.judged_on,
        frozen=frozen,
        identified_from=model.runs,
        with_reversals=scores(end.first).rms_with_reversals,
        above_band=rest.above_band,
        knocked=rest.knocked,
        only="" if only is None else effect(only[0]).named,
        absorbed=not (whole or findings) and absorbed(state, search.suspects),
        lacked=tuple(
            j
            for j in range(model.robot.n)
            if state.usual is not None and end.left.rms[j] <= state.usual[j] and not stood.far[j]
        ),
        stood=stood.words,
        told=_known_before(model),
        at_none=held_at_none(end.versions[-1], state),
        sharper=sharpened(model, state) if frozen else {},
        passed=channel_words(state) if smoothed else "",
        thought=str(model.channel) if smoothed and model.channel else "",
    )


def _known_before(model: TorqueModel) -> tuple[str, ...]:
    """Of which parameters somebody knew something when the model was identified."""
    prior = model.notes.prior
    if prior is None:
        return ()
    names = tuple(one.name for one in prior.given)
    return names if prior.percent is None else ("all bodies", *names)
