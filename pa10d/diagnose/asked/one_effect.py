"""One effect that somebody names, fitted into a model on the joints that they name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from pa10d.common.errors import UserError
from pa10d.common.parallel import one_thread
from pa10d.diagnose.outcome.held import held_at_none, held_words
from pa10d.diagnose.search.begun import Begun, begin
from pa10d.diagnose.search.delivery import warnings as said
from pa10d.diagnose.search.none_at_least import or_none_at_least
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.suspects import label, lacking
from pa10d.diagnose.search.versions import snapshot, unseen
from pa10d.diagnose.search.whole import fitted_to_all
from pa10d.effects import effect
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel

Progress = Callable[[float, str], None]


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
    asked = lacking(model, effect_id, joints)
    begun = begin(model, fit, validate)

    def fitted(one: Begun) -> Search:
        return _fitted(Search(one.state, asked, one.given), effect_id, say)

    begun, search = or_none_at_least(
        begun, fitted(begun), lambda: begin(model, fit, validate, none_at_least=True), fitted
    )
    model, given = begun.model, begun.given
    there = {(t.effect.id, t.joints) for t in search.state.terms[given:]}
    warnings = [
        f"{label(kind, place)}: this data cannot tell it from what the model has; it was left out"
        for kind, place in search.suspects
        if (kind.id, place) not in there
    ]
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
    made = snapshot(model, state, len(state.terms), begun.as_given)
    warnings += [*unseen(made, state, given).values(), *held_words(held_at_none(made, state))]
    held = state.held.everywhere.runs
    (made,) = fitted_to_all(model, [made], begun.fit, held, state.none_at_least)
    warnings += said(made)
    return replace(made, name=name, change=f"added {added}"), warnings


def _fitted(search: Search, effect_id: str, say: Progress) -> Search:
    """With what was asked for, as far as this data can tell it from what the model has."""
    for number, (kind, place) in enumerate(search.suspects):
        say(0.2 + 0.6 * number / len(search.suspects), f"fitting {effect_id}")
        best = search.best(kind, place)
        if best is not None:
            search.state.push(best.term)  # the search may have gone on with a copy
            search.state = search.state.where_shared_slips()
            search.settle(rounds=1)
    return search
