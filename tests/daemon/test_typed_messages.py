"""What goes between the processes, parsed once where it arrives; clients see what they saw."""

from __future__ import annotations

import json

import pytest

from pa10d.common.errors import Taken, Unsound, UserError
from pa10d.common.jsonable import plain
from pa10d.control.computed_torque import BY_NAME
from pa10d.control.laws import WITH_MODEL
from pa10d.control.messages import AskErrors, Do, FollowRows, read_command
from pa10d.daemon.processes.workers import TaskEnd, TaskFailed
from pa10d.experiments.checks import Check
from pa10d.experiments.outcome import Outcome, RecordedRun, SeriesOutcome
from pa10d.experiments.prepared import PlannedMotion, Prepared, wrong_in
from pa10d.experiments.request import LawUsed, MotionRequest, TrackingRequest


def test_an_outcome_tells_what_is_known_of_it():
    found = Outcome("tracking")
    assert found.document() == {"kind": "tracking", "runs": [], "recorded": []}
    found.recorded.append(RecordedRun("id", "r1", "success", 2.0))
    found.checks, found.recommendation = [Check("ok", "bus", "fits", 2)], []
    said = found.document()
    assert said["recorded"] == [{"id": "id", "name": "r1", "status": "success", "duration": 2.0}]
    assert said["checks"] == [
        {"level": "ok", "subject": "bus", "sentence": "fits", "joint": 2, "time": None}
    ]
    assert said["recommendation"] == []
    assert not {"notes", "tuned", "adjusted"} & said.keys()
    found.plan, found.seconds = {}, 2.0
    assert found.document()["adjusted"] is None, "it moved as it was asked to"
    said = found.document()
    assert SeriesOutcome(["id"], [found]).document() == {"runs": ["id"], "experiments": [said]}


def test_a_prepared_motion_comes_through_the_pipe_as_it_was():
    motion = PlannedMotion("rows.npy", 100, 10, 90, 1.0, "plan.json")
    checks = (Check("error", "position", "too far", 1, 0.5), Check("ok", "bus", "fits"))
    made = Prepared(checks, {"sentence": "slower"}, {}, {}, (0.0, 1.0), None, (motion, motion))
    again = Prepared.from_document(json.loads(json.dumps(plain(made))))
    assert again == made
    assert (again.seconds, again.sentence, wrong_in(list(again.checks))) == (
        2.0, "slower", ["too far"],
    )  # fmt: skip


def test_a_plan_is_a_whole_request():
    asked = MotionRequest.of_plan({"kind": "step", "parameters": None, "why": "…"}, ["fit"])
    assert asked.document() == {
        "kind": "step", "parameters": {}, "name": None, "tags": ["fit"], "controller": None,
        "model": None, "replace": False, "recover": False,
    }  # fmt: skip


def test_every_law_gets_its_run():
    asked = TrackingRequest("tracking", {"cycles": 2}, ["m0", "m1"], "worth")
    assert asked.laws == [
        LawUsed("pid"),
        LawUsed("feed_forward", "m0"), LawUsed("feed_forward", "m1"),
        LawUsed("computed_torque", "m0"), LawUsed("computed_torque", "m1"),
    ]  # fmt: skip
    motions = asked.motions(["track"])
    assert [one.name for one in motions] == [f"worth-{k}" for k in range(1, 6)]
    assert [(one.controller, one.model) for one in motions] == [
        (law.controller, law.model) for law in asked.laws
    ]


def test_every_law_with_a_model_has_its_class():
    assert tuple(BY_NAME) == WITH_MODEL


@pytest.mark.parametrize(
    ("message", "command"),
    [
        ({"do": "run", "descriptors": [9], "number": "3", "first": 1, "last": 2},
         FollowRows(3, 9, 1, 2)),
        ({"do": "run", "descriptors": [9], "number": 3, "first": 1, "last": 2,
          "weight": [[1, 2], [3, 4]]},
         FollowRows(3, 9, 1, 2, ((1.0, 2.0), (3.0, 4.0)))),
        ({"do": "errors"}, AskErrors(False)),
        ({"do": "stop", "id": 7}, Do("stop")),
    ],
)  # fmt: skip
def test_a_command_is_read(message, command):
    assert read_command(message) == command


@pytest.mark.parametrize("message", [{}, {"do": "dance"}, {"do": ["stop"]}])
def test_what_is_no_command_is_said(message):
    with pytest.raises(ValueError, match="unknown command"):
        read_command(message)


@pytest.mark.parametrize(
    ("answer", "kind"),
    [
        (TaskEnd(error="no", expected=True), UserError),
        (TaskEnd(error="no", expected=True, findings=[{}]), Unsound),
        (TaskEnd(error="no", expected=True, taken=True), Taken),
        (TaskEnd(error="no"), TaskFailed),
    ],
)
def test_a_task_fails_as_what_it_said(answer, kind):
    with pytest.raises(kind, match="no") as seen:
        answer.outcome()
    assert type(seen.value) is kind


def test_a_task_s_result_may_be_nothing():
    assert TaskEnd().outcome() is None
