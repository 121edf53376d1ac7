"""What lies in the data folder is input, and only one process at a time carries one out."""

from __future__ import annotations

import json

import pytest
from made_up import answer, finding, investigation, walk

from pa10d.common.errors import UserError
from pa10d.common.jsonable import parsed
from pa10d.investigation import course
from pa10d.investigation.archive import STATE, Archive
from pa10d.investigation.document import document
from pa10d.investigation.results import Searched, StepOutcome
from pa10d.services.documents import SCHEMAS


@pytest.fixture
def archive(tmp_path):
    return Archive(tmp_path)


def test_it_comes_back_as_it_was(archive):
    state = investigation()
    walk(state, answer(finding()))
    archive.save(state)
    assert archive.load(state.id) == state
    assert archive.find("look") == archive.find(state.id[:12]) == state


def test_one_whose_process_has_died_can_be_taken_up(archive):
    state = investigation()
    course.begun(state, course.next_step(state))
    archive.save(state)
    with archive.carrying_out(state.id):
        assert archive.load(state.id).status == "running"
        with pytest.raises(UserError, match="another process"), archive.carrying_out(state.id):
            pass
    found = archive.load(state.id)
    assert found.status == "stopped"
    assert "ended before it was done" in found.error
    assert course.next_step(found).status == "waiting"


@pytest.mark.parametrize(
    ("place", "value", "says"),
    [
        (["status"], "dancing", "status"),
        (["steps", 0, "kind"], "shell", "steps.0.kind"),
        (["steps", 0, "motion", "seconds"], -1.0, "seconds"),
        (["steps", 0, "runs"], ["../../etc"], "runs"),
        (["steps", 7, "result"], {"verdict": "maybe"}, "verdict"),
        (["steps", 7, "result", "noise_floor"], ["many"], "noise_floor"),
        (["id"], "20260101-000000000-ffffff", "expected its folder's"),
        (["minutes"], "many", "minutes"),
        (["surprise"], 1, "surprise"),
    ],
)
def test_a_damaged_one_is_set_aside_with_a_line(archive, place, value, says):
    state = investigation()
    walk(state, answer(finding()))
    archive.save(state)
    path = archive.place(state.id) / STATE
    inside = whole = json.loads(path.read_text())
    for key in place[:-1]:
        inside = inside[key]
    inside[place[-1]] = value
    path.write_text(json.dumps(whole))
    assert archive.all() == []
    (aside,) = archive.set_aside()
    assert says in aside.reason
    with pytest.raises(UserError):
        archive.find(state.id)


@pytest.mark.parametrize("content", [b"", b"{", b"\xff\xfe", b"[]", b"null"])
def test_what_is_no_investigation_harms_no_other(archive, content):
    good = investigation()
    archive.save(good)
    bad = archive.place("20260101-000000001-bad000")
    bad.mkdir()
    (bad / STATE).write_bytes(content)
    (archive.folder / "notes.txt").write_text("mine")
    assert archive.all() == [good]
    assert len(archive.set_aside()) == 2


def test_a_link_is_not_followed(archive, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (archive.folder / "20260101-000000001-link00").symlink_to(tmp_path / "elsewhere")
    assert "a link" in archive.set_aside()[0].reason


def test_its_document_fits_its_schema_at_every_step(tmp_path):
    state, schema, data = investigation(), SCHEMAS["investigate"], str(tmp_path)
    answers = [answer(finding({"kind": "chirp", "parameters": {}})), answer(finding())]
    judged = {"fresh": True, "runs": ["r"], "models": ["a", "b"], "before": [1.0], "after": [0.5],
              "noise_floor": [None], "cutoff_hz": 10.0, "mask": "all"}  # fmt: skip
    while (step := course.next_step(state)) is not None:
        schema.model_validate(document(state, data))
        course.begun(state, step)
        result = {"diagnose": lambda: answers.pop(0), "judge": lambda: judged}
        course.done(state, step, StepOutcome(result=result.get(step.kind, dict)()))
    found = document(state, data)
    schema.model_validate(found)
    assert found["status"] == "done"
    assert found["report"] is None, "no file, no path"
    assert parsed(Searched, found).verdict == "missing"
