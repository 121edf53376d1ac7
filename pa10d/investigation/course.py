"""Which steps an investigation has, and which comes next: pure functions of its state.

Nothing here computes, moves or writes. Whoever carries a step out tells ``done`` what came of it;
a step that was interrupted is simply the next one again.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

from pa10d.common.errors import UserError
from pa10d.common.words import listed
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.investigation.results import NamedEffect, StepOutcome
from pa10d.investigation.state import ArmMotion, Investigation, Step

MOST = 2  # experiments to settle doubts; what is then still in doubt stays so
FIRST = ("joints", "fit", "judge")
"""Purposes without which there is no answer; of the last two one motion each is enough."""


def first_steps(
    motions: Sequence[tuple[ArmMotion, str]], question: str, minutes: float | None
) -> list[Step]:
    """The steps as they are known before anything was measured. motions: each with what keeps it
    from being run, or "". Those beyond the budget are left out, and say so."""
    chosen = within([motion for motion, problem in motions if not problem], minutes)
    steps = []
    for k, (motion, problem) in enumerate(motions, 1):
        step = Step(id=f"motion-{k}", kind="motion", title=_title(motion), motion=motion)
        if motion not in chosen:
            _leave_out(step, problem or _beyond(motion, minutes))
        steps.append(step)
    before = [s for s in steps if s.motion is not None and s.motion.purpose != "fresh"]
    fresh = [s for s in steps if s not in before]
    textbook = [
        Step(id="identify", kind="identify", title="Fit the textbook model"),
        Step(id="compare", kind="compare", title="See where it fails on runs it has not seen"),
    ]
    asks = "Ask what has changed" if question == "changed" else "Ask which effect is missing"
    return [
        *before,
        *([] if question == "changed" else textbook),
        Step(id="diagnose-1", kind="diagnose", title=asks),
        Step(id="add", kind="add", title="Add what was found, as new versions"),
        *fresh,
        Step(id="judge", kind="judge", title=_judged_by(steps)),
        Step(id="report", kind="report", title="Write the report"),
    ]


def within(motions: Sequence[ArmMotion], minutes: float | None) -> list[ArmMotion]:
    """Those that fit: what no answer can do without first, then the others in their order.

    UserError where not even the former fit.
    """
    if minutes is None:
        return list(motions)
    left, least = 60.0 * minutes, _least(motions)
    needed = sum(motion.seconds for motion in least)
    if needed > left:
        named = listed([f"{m.kind} ({m.seconds:.0f} s)" for m in least])
        raise UserError(
            f"--minutes {minutes:g}: the least that gives an answer is {named}, "
            f"{needed:.0f} s of motion; expected at least {needed / 60:.1f} minutes"
        )
    chosen, left = list(least), left - needed
    for motion in motions:
        if motion not in chosen and motion.seconds <= left:
            chosen.append(motion)
            left -= motion.seconds
    return [motion for motion in motions if motion in chosen]


def next_step(state: Investigation) -> Step | None:
    """The first one that is not over."""
    return next((s for s in state.steps if s.status in ("waiting", "running")), None)


def begun(state: Investigation, step: Step) -> None:
    """It is being carried out."""
    step.status, step.started, step.finished = "running", _now(), None
    state.status, state.error = "running", ""


def put_back(state: Investigation, status: str, error: str = "") -> None:
    """What was being done is to be done again; the rest stays as it is."""
    for step in state.steps:
        if step.status == "running":
            step.status, step.started = "waiting", None
    state.status, state.error = status, error[:4000]  # type: ignore[assignment]


def done(state: Investigation, step: Step, outcome: StepOutcome) -> None:
    """It ended well. What follows from that is added to the steps."""
    step.runs, step.models = list(outcome.runs), list(outcome.models)
    step.moved, step.result = outcome.moved, outcome.result
    step.said, step.status, step.finished = outcome.said[:4000], "done", _now()
    step.notes, step.tuned = [note[:4000] for note in outcome.notes[:100]], list(outcome.tuned)
    if step.kind == "diagnose":
        _after_search(state, step)
    if next_step(state) is None:
        state.status = "done"


def left_out(state: Investigation, step: Step, why: str) -> None:
    """It cannot be done, and the others go on without it; the last judgement says so, too."""
    _leave_out(step, why)
    if step.motion is not None and step.motion.purpose == "fresh":
        state.step("judge").title = _judged_by(state.steps)


def _leave_out(step: Step, why: str) -> None:
    step.status, step.said, step.finished = "left_out", why[:4000], _now()


def needs(state: Investigation, step: Step) -> None:
    """UserError where a step has nothing to work on."""
    if step.kind == "identify" and not state.to_fit:
        said = [s.said for s in state.steps if s.kind == "motion" and s.status == "left_out"]
        raise UserError(f"nothing was recorded that a model could be fitted to: {listed(said[:3])}")


def budget_left(state: Investigation) -> float:
    """s of motion that are not yet spent or promised to a step; endless without a budget."""
    if state.minutes is None:
        return float("inf")
    waiting = [s.motion.seconds for s in state.steps if s.status == "waiting" and s.motion]
    return 60.0 * state.minutes - state.moved - sum(waiting)


def spent(state: Investigation, step: Step) -> bool:
    """Whether a motion no longer fits, because those before it took longer than expected; what no
    answer can do without is moved all the same."""
    motion = step.motion
    if motion is None or state.minutes is None:
        return False
    if motion.purpose in FIRST and not state.recorded(motion.purpose):
        return False
    return state.moved + motion.seconds > 60.0 * state.minutes


def doubt(state: Investigation) -> NamedEffect | None:
    """The first finding whose settling experiment was not run yet."""
    tried = [
        NextExperiment(s.motion.kind, s.motion.parameters)
        for s in state.steps
        if s.motion is not None and s.motion.purpose == "settle" and s.status != "waiting"
    ]
    asked = (one for one in state.findings if one.next_experiment is not None)
    return next((one for one in asked if one.next_experiment not in tried), None)


def _after_search(state: Investigation, step: Step) -> None:
    at = state.steps.index(step) + 1
    finding = doubt(state)
    settled = [s for s in state.steps if s.motion is not None and s.motion.purpose == "settle"]
    if finding is not None and state.moves and len(settled) < MOST:
        state.steps = [*state.steps[:at], *_settling(state, finding, len(settled) + 1),
                       *state.steps[at:]]  # fmt: skip
        if next_step(state) is not state.step("add"):
            return
    if not state.findings:
        left_out(state, state.step("add"), "There is nothing to add.")
        for other in state.steps:
            if other.motion is not None and other.motion.purpose == "fresh":
                left_out(state, other, "Nothing was added that fresh motion could judge.")


def _settling(state: Investigation, finding: NamedEffect, number: int) -> list[Step]:
    """The experiment and another search; where the budget does not reach, one that is left out."""
    plan, way = finding.next_experiment, finding.settling
    assert plan is not None
    assert way is not None
    motion = ArmMotion(
        purpose="settle", kind=plan.kind, parameters=plan.parameters,
        seconds=way.seconds, why=way.says,
    )  # fmt: skip
    step = Step(id=f"settle-{number}", kind="motion", title=_title(motion), motion=motion)
    if way.seconds > budget_left(state):
        _leave_out(step, _beyond(motion, state.minutes))
        return [step]
    again = Step(id=f"diagnose-{number + 1}", kind="diagnose", title="Ask again, with that motion")
    return [step, again]


def _least(motions: Sequence[ArmMotion]) -> list[ArmMotion]:
    found: list[ArmMotion] = []
    for purpose in FIRST:
        found += [motion for motion in motions if motion.purpose == purpose][:1]
    return found


def _title(motion: ArmMotion) -> str:
    words = motion.kind.replace("_", " ").capitalize()
    ends = {
        "joints": "measures each joint",
        "fit": "to fit to",
        "judge": "to judge by",
        "settle": "settles a doubt",
        "fresh": "fresh motion, for the last judgement",
    }
    return f"{words}: {ends[motion.purpose]}"


def _judged_by(steps: Sequence[Step]) -> str:
    fresh = [s for s in steps if s.motion is not None and s.motion.purpose == "fresh"]
    if any(step.status != "left_out" for step in fresh):
        return "Judge it on fresh motion"
    return "Judge all versions on the runs to judge by"


def _beyond(motion: ArmMotion, minutes: float | None) -> str:
    return (
        f"{motion.kind} takes {motion.seconds:.0f} s, which the budget of {minutes:g} minutes does "
        "not hold."
    )


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
