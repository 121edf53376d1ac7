"""Whatever the public face gives back: equal by content, never changed, short to read, shown."""

from __future__ import annotations

import copy
import html
import inspect
import pickle
import re
from dataclasses import FrozenInstanceError, is_dataclass

import numpy as np
import pytest

import pa10d
from pa10d.face import answers, effects, model, robot, run, told
from pa10d.face.values import ByContent

ROOMS = (answers, effects, model, robot, run, told)
LINES, LONGEST = 8, 400  # of a repr that a person reads


@pytest.fixture(scope="module")
def story(half_a_minute):
    """One of each, and how it is made again."""
    machine = pa10d.load_robot(half_a_minute / "robot.urdf")
    train = pa10d.load_run(half_a_minute / "train.csv", machine)
    valid = pa10d.load_run(half_a_minute / "valid.csv", machine)
    first = pa10d.identify(machine, [train])
    better = pa10d.improve(first, fit=[train], validate=[valid])
    return {
        "Robot": machine,
        "Run": train,
        "Model": first,
        "Comparison": pa10d.compare(first, [valid]),
        "Diagnosis": better.diagnosis,
        "Finding": better.diagnosis.findings[0],
        "Improvement": better,
    }


@pytest.fixture(scope="module")
def parts(story):
    """One of each kind of thing inside them."""
    found = story["Finding"]
    plan = {"kind": "tracking", "parameters": {"period": 4.0}}
    return {
        "Parameter": story["Model"].base_parameters[0],
        "Effect": story["Model"].effects[0],
        "KnownEffect": pa10d.effects()[0],
        "Where": story["Comparison"].where[0],
        "Confusion": told.confusion({"effect": "stribeck", "joints": [1], "why": "looks alike"}),
        "NextExperiment": found.next_experiment or told.next_experiment(plan),
        "Unexplained": told.unexplained(
            {"joint": 1, "depends_on": ["q1"], "share": 0.5, "rms": 0.1, "p_value": 1e-9}
        ),
        "Remaining": story["Diagnosis"].remaining[0],
    }


@pytest.mark.long
def test_none_is_left_out(story, parts):
    """A class that is added to the face and that nobody looks at here is told."""
    classes = {
        name
        for room in ROOMS
        for name, kind in vars(room).items()
        if inspect.isclass(kind) and kind.__module__ == room.__name__ and name[0] != "_"
    }
    assert classes - {"Answer", "ByKey"} == {*story, *parts}
    public = {name for name in pa10d.__all__ if inspect.isclass(getattr(pa10d, name))}
    assert public - {"Cancelled", "UserError"} == {n for n, v in story.items() if _shown(v)}


def _shown(value):
    return isinstance(value, ByContent)


def test_they_are_equal_by_content(story, parts):
    for name, value in {**story, **parts}.items():
        again = copy.deepcopy(value)
        assert again is not value or is_dataclass(value), name
        assert again == value, name
        assert hash(again) == hash(value), name
        assert value != object(), name
        assert len({value, again}) == 1, name
    values = list(story.values())
    assert len(set(values)) == len(values)


def test_what_another_process_gives_back_is_the_same(story, parts):
    for name, value in {**story, **parts}.items():
        assert pickle.loads(pickle.dumps(value)) == value, name


def test_nothing_of_them_can_be_set(story, parts):
    for name, value in story.items():
        for attribute in (*vars(value), "new"):
            with pytest.raises(AttributeError, match=r"never changes|no setter"):
                setattr(value, attribute, None)
        with pytest.raises(AttributeError):
            delattr(value, next(iter(vars(value))))
        before = hash(value)
        for attribute in dir(type(value)) + list(vars(value)):
            found = getattr(value, attribute) if attribute[0] != "_" else None
            if isinstance(found, np.ndarray):
                assert not found.flags.writeable, f"{name}.{attribute}"
        assert hash(value) == before, name
    for value in parts.values():
        with pytest.raises(FrozenInstanceError):
            setattr(value, next(iter(vars(value))), None)


def test_the_document_of_an_answer_is_a_copy(story):
    for name in ("Comparison", "Diagnosis"):
        value = story[name]
        before = hash(value)
        for entry in value.document().values():
            if isinstance(entry, list):
                entry.clear()
        assert hash(value) == before, name


def test_their_reprs_are_a_few_lines(story, parts):
    for name, value in {**story, **parts}.items():
        lines = repr(value).splitlines()
        assert 1 <= len(lines) <= LINES, name
        assert max(map(len, lines)) <= LONGEST, name
        assert "object at 0x" not in repr(value), name
        assert name in repr(value), name


def test_a_notebook_shows_each(story):
    """Whole, apart, nothing loaded from elsewhere; with plots where there is something to draw."""
    for name, value in story.items():
        frame = value._repr_html_()
        assert frame.startswith("<iframe"), name
        page = html.unescape(frame.partition('srcdoc="')[2])
        assert "<h1>" in page, name
        told = re.sub(r"<(script|style).*?</\1>", "", page, flags=re.S)
        assert not re.search(r"\b(nan|None|inf)\b", told), name
        assert not re.search(r'(src|href)="(https?:)?//', told), name
        drawn = 'data-figure="' in page
        assert drawn == (name != "Robot"), name
        assert drawn == ("Plotly.react" in page and len(page) > 500_000), name


def test_what_is_said_of_a_joint_reads_by_key_as_well(story):
    line = story["Diagnosis"].remaining[0]
    assert line["sentence"] == line.sentence == str(line)
    with pytest.raises(KeyError, match="of_tomorrow"):
        line["of_tomorrow"]
    plan = told.next_experiment({"kind": "chirp", "parameters": {"joints": [1]},
                                 "about": {"expected_standard_errors": 5.0}})  # fmt: skip
    assert plan["kind"] == "chirp"
    assert plan.document()["about"] == {"expected_standard_errors": 5.0}
    assert plan.command.startswith("pa10d experiment chirp --set")
    with pytest.raises(TypeError):
        plan.parameters["joints"] = [2]
