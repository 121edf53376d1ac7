"""Which steps there are and which comes next, whatever is found, within every budget."""

from __future__ import annotations

from dataclasses import replace

import pytest
from made_up import SET, answer, finding, investigation, motion, walk

from pa10d.common.errors import UserError
from pa10d.common.jsonable import parsed
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.investigation import course
from pa10d.investigation.results import NamedEffect, Rival, StepOutcome
from pa10d.investigation.words import doubt_words

SWEEP = {"kind": "velocity_sweep", "parameters": {"joints": [4]}}
CHIRP = {"kind": "chirp", "parameters": {"joints": [4]}}
RECORD = [f"motion-{k}" for k in range(1, 6)]
BEGIN = [*RECORD, "identify", "compare", "diagnose-1"]


def test_what_is_found_is_added_and_judged_on_fresh_motion():
    state = investigation()
    assert walk(state, answer(finding())) == [*BEGIN, "add", "motion-6", "judge", "report"]
    assert state.status == "done"
    assert state.versions == ["look-m0", "look-m1"]
    assert state.recorded("fresh") == ["run-of-motion-6"]
    assert "run-of-motion-6" not in [*state.to_fit, *state.to_judge], "nobody has seen it"


def test_where_nothing_is_found_nothing_more_moves():
    state = investigation()
    assert walk(state, answer()) == [*BEGIN, "judge", "report"]
    assert state.step("add").status == state.step("motion-6").status == "left_out"


def test_a_doubt_adds_its_experiment_and_another_search():
    state = investigation()
    made = walk(state, answer(finding(SWEEP)), answer(finding()))
    assert made[len(BEGIN) :] == ["settle-1", "diagnose-2", "add", "motion-6", "judge", "report"]
    settled = "run-of-settle-1"
    assert settled in state.to_fit
    assert settled in state.to_judge, "on both sides it is split by time"
    assert settled not in state.unseen


def test_the_same_doubt_is_not_settled_twice():
    state = investigation()
    made = walk(state, answer(finding(SWEEP)), answer(finding(SWEEP)))
    assert [m for m in made if m.startswith("settle")] == ["settle-1"]


def test_doubts_without_end_do_not_move_the_arm_for_ever():
    state = investigation()
    plans = [{**CHIRP, "parameters": {"seed": k}} for k in range(9)]
    made = walk(state, *(answer(finding(plan)) for plan in plans))
    assert sum(m.startswith("settle") for m in made) == course.MOST
    assert state.status == "done"


def test_a_search_that_takes_its_finding_back_leaves_nothing_to_add():
    state = investigation()
    made = walk(state, answer(finding(SWEEP)), answer())
    assert "add" not in made
    assert "motion-6" not in made


def test_recordings_need_no_motion_and_get_none():
    state = investigation(motions=[], fit=["a"], validate=["b"])
    made = walk(state, answer(finding(SWEEP)))
    assert made == ["identify", "compare", "diagnose-1", "add", "judge", "report"]
    assert state.to_judge == state.unseen == ["b"]


def test_what_changed_is_asked_of_the_model_as_it_was():
    state = investigation(question="changed", model="m0", motions=[SET[1], SET[3], SET[5]])
    made = walk(state, answer(finding()))
    assert made == ["motion-1", "motion-2", "diagnose-1", "add", "motion-3", "judge", "report"]
    assert state.versions == ["m0", "look-m1"]


@pytest.mark.parametrize(
    ("minutes", "kept"),
    [
        (None, [0, 1, 2, 3, 4, 5]),
        (250 / 60, [0, 1, 2, 3, 4, 5]),
        (210 / 60, [0, 1, 2, 3, 4]),
        (165 / 60, [0, 1, 3, 4]),
        (135 / 60, [0, 1, 3]),
    ],
)
def test_a_budget_leaves_out_what_does_not_fit_and_says_so(minutes, kept):
    state = investigation(minutes)
    waiting = [k for k, m in enumerate(SET) if state.step(f"motion-{k + 1}").status == "waiting"]
    assert waiting == kept
    for k in set(range(6)) - set(kept):
        assert "does not hold" in state.step(f"motion-{k + 1}").said
    walk(state, answer(finding()))
    assert minutes is None or state.moved <= 60 * minutes


def test_less_than_an_answer_needs_is_refused_with_what_it_needs():
    with pytest.raises(UserError, match=r"excitation \(30 s\).*expected at least 2.2 minutes"):
        investigation(2.0)


def test_a_doubt_beyond_the_budget_stays_and_says_why():
    state = investigation(255 / 60)
    made = walk(state, answer(finding(SWEEP, seconds=50.0)))
    assert "settle-1" not in made
    assert state.step("settle-1").status == "left_out"
    assert "budget of 4.25 minutes" in state.step("settle-1").said
    assert state.moved <= 255
    assert "motion-6" in made, "time for the last judgement was kept"


@pytest.mark.parametrize("ended", ["stopped", "failed", "paused"])
@pytest.mark.parametrize("after", range(12))
def test_whatever_ended_it_what_is_done_is_not_done_again(after, ended):
    state = investigation()
    answers, made = [answer(finding(SWEEP)), answer(finding())], []
    for _ in range(after):
        step = course.next_step(state)
        if step is None:
            break
        course.begun(state, step)
        outcome = {"result": answers.pop(0)} if step.kind == "diagnose" else {}
        outcome |= {"runs": ["r"]} if step.kind == "motion" else {}
        outcome |= {"models": [step.id]} if step.kind in ("identify", "add") else {}
        course.done(state, step, StepOutcome(**outcome))
        made.append(step.id)
    if (step := course.next_step(state)) is not None:
        course.begun(state, step)
    course.put_back(state, ended, "why")
    assert not [s for s in state.steps if s.status == "running"]
    rest = walk(state, *answers)
    assert len(set([*made, *rest])) == len([*made, *rest])
    assert [*made, *rest][-1] == "report"
    assert state.status == "done"


def test_without_any_recording_it_says_why_nothing_was_recorded():
    state = investigation()
    for k in range(1, 6):
        course.left_out(state, state.step(f"motion-{k}"), f"motion {k} meets the floor")
    step = course.next_step(state)
    assert step.id == "identify"
    with pytest.raises(UserError, match="motion 1 meets the floor"):
        course.needs(state, step)


def test_motions_that_cannot_be_planned_are_left_out_with_their_reason():
    pairs = [(SET[1], ""), (motion("judge", 0.0, "point_to_point"), "no free pose")]
    steps = course.first_steps(pairs, "missing", 10.0)
    assert (steps[1].status, steps[1].said) == ("left_out", "no free pose")


def test_a_plan_is_known_by_what_it_does_not_by_what_is_said_about_it():
    nine, three = ({"about": {"expected_standard_errors": value}} for value in (9.0, 3.0))
    state = investigation()
    made = walk(state, answer(finding(SWEEP | nine)), answer(finding(), finding(SWEEP | three)))
    assert [m for m in made if m.startswith("settle")] == ["settle-1"]


def test_what_took_longer_than_expected_is_taken_from_what_can_be_spared():
    state = investigation(210 / 60)
    for step in state.steps[:4]:
        course.begun(state, step)
        course.done(state, step, StepOutcome(runs=["r"], moved=1.1 * step.motion.seconds))
    assert state.moved + SET[4].seconds > 210
    assert course.spent(state, state.step("motion-5"))
    assert not course.spent(state, state.step("identify"))
    short = investigation(135 / 60)
    course.done(short, short.step("motion-1"), StepOutcome(moved=134.0))
    assert not course.spent(short, short.step("motion-2")), "without it there is no answer"


def test_a_doubt_reads_like_a_sentence():
    plan = NextExperiment.read(SWEEP)
    doubt = parsed(NamedEffect, finding(SWEEP))
    said = doubt_words(doubt, plan)
    assert said.startswith(
        "Stribeck friction in joint 4 could also be Coulomb friction in joint 4. The experiment"
    )
    other = replace(doubt, confounded_with=[Rival("spring", [2], "alike")])
    assert "could also be a spring in joint 2." in doubt_words(other, plan)
