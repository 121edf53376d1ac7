"""The demo: what it hides stays hidden, what it says is measured, and wrong answers are said."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from backends.virtual.datasets import foreign_runs, make_runs
from backends.virtual.plant import build
from backends.virtual.plant.catalogue import LISTED
from pa10d.cli import main
from pa10d.errors import UserError
from pa10d.profile import Simulation, load_profile
from pa10d.services.demo import judged, play, verdict_on
from pa10d.services.demo_arm import Hidden, hide, record
from pa10d.services.library import open_library

PROFILE = load_profile("pa10-sim")
HERE = __name__


def quiet_plant(profile, seed):
    """The arm of ``make_runs(seed, noise="none")``, as somebody else's factory."""
    return build(profile, noise="none", seed=1, dynamics={"spread": 0.2, "seed": seed})


def foreign_profile(**options):
    simulation = Simulation(plant=f"{HERE}:quiet_plant", options=options)
    return PROFILE.model_copy(update={"simulation": simulation})


@pytest.fixture(scope="module")
def story(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    library, lines = open_library(folder), []
    told = play(
        library, "pa10-sim", asked="payload", seed=2, report=folder / "report.html",
        tell=lines.append, progress=lambda share, what: None, seconds=10.0,
    )  # fmt: skip
    return told, library, " ".join(lines)


def test_a_payload_is_found_and_the_error_falls(story):
    told = story[0]
    answer = told.document()
    assert answer["right"] is True
    assert (answer["hidden"], answer["found"], answer["joint"]) == ("payload", "payload", None)
    mass = told.diagnosis.findings[0].parameters["mass"]
    assert mass.value == pytest.approx(told.hidden.effects[0]["mass"], abs=5 * mass.std_error)
    worst = int(np.argmax(answer["rms_before"]))
    assert answer["rms_after"][worst] < 0.1 * answer["rms_before"][worst]


def test_runs_and_models_are_in_the_store(story):
    told, library, _ = story
    stored = {info.name for info in library.runs.all()}
    kinds = ("ref_a", "ref_b", "train_a", "train_b", "valid_a", "valid_b")
    assert stored == {f"demo2-{kind}" for kind in kinds}
    history = library.models.history(library.models.find(told.models[-1]))
    assert [info.name for info in history] == list(told.models)


def test_only_measurements_are_stored(story):
    """Angles and torques: no name, size or temperature that gives the effect away."""
    library = story[1]
    for info in library.runs.all():
        run = library.runs.recording(info)
        assert run.dq is None
        assert run.temperature is None
        assert not run.extra
        assert b"payload" not in (library.runs.path(info) / "run.mcap").read_bytes()


def test_the_truth_comes_last(story):
    told, _, words = story
    before, after = words.split("7. Now the simulator tells")
    assert str(told.hidden.effects[0]["mass"]) not in before
    assert told.hidden.in_words() in after
    text = told.report.read_text(encoding="utf-8")
    assert told.hidden.in_words() in text
    assert "The diagnosis was right." in text


def test_the_same_by_hand_with_a_report(story, tmp_path, capsys):
    """``diagnose --report`` on the demo's own runs: what the documentation suggests."""
    told, library, _ = story
    file = tmp_path / "again.html"
    arguments = [
        "diagnose", "demo2-m0", "--frozen", "--effect", "payload",
        "--fit", "demo2-train_a", "demo2-train_b", "--validate", "demo2-valid_a", "demo2-valid_b",
    ]  # fmt: skip
    data = ["--data", str(library.runs.folder.parent), "--json"]
    assert main([*data, *arguments, "--report", str(file)]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["report"] == str(file)
    assert answer["findings"][0]["effect"] == "payload"
    mass = told.diagnosis.findings[0].parameters["mass"].value
    assert answer["findings"][0]["parameters"]["mass"]["value"] == pytest.approx(mass, rel=1e-3)
    assert "What changed: Payload." in file.read_text(encoding="utf-8")
    assert main([*data, *arguments, "--report", str(tmp_path / "none" / "x.html")]) == 1
    assert "expected a file that can be written" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("hidden", "right", "says"),
    [
        (Hidden(({"effect": "base_tilt", "x": 0.02},)), False, "wrong: it named Payload"),
        (Hidden(), False, "wrong: it named Payload"),
        (Hidden(({"effect": "windage", "joint": 2, "drag": 1.0},)), False, "wrong"),
        (Hidden(foreign=True), None, "known to whoever wrote it"),
    ],
)
def test_a_wrong_answer_is_called_wrong(story, hidden, right, says):
    found = story[0].diagnosis
    assert judged(hidden, found) is right
    assert says in verdict_on(hidden, found, right)


def test_finding_nothing_is_right_only_where_nothing_is_hidden(story):
    silent = replace(story[0].diagnosis, findings=(), verdict="none")
    assert judged(Hidden(), silent) is True
    assert judged(Hidden(({"effect": "payload", "mass": 1.0},)), silent) is False


def test_what_is_hidden_follows_from_the_seed_alone():
    drawn = [hide(None, seed, PROFILE) for seed in (1, 2, 4, 1)]
    assert drawn[0] == drawn[3]
    assert len({h.name for h in drawn}) == 3
    assert {h.name for h in drawn} <= set(LISTED)


@pytest.mark.parametrize(
    ("asked", "joints"), [("stribeck:4", (4,)), ("torque_ripple:1", (1,)), ("none", ())]
)
def test_an_effect_sits_where_it_was_asked_for(asked, joints):
    assert hide(asked, 5, PROFILE).joints == joints


def test_a_pair_holds_the_joint_asked_for():
    assert 6 in hide("coupling_friction:6", 5, PROFILE).joints


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ("gremlins", "no such effect, expected none or one of torque_offset"),
        ("stribeck:8", "joint '8', expected a number from 1 to 7"),
        ("stribeck:x", "joint 'x', expected a number from 1 to 7"),
        ("payload:3", "payload is of the whole arm, expected no joint"),
    ],
)
def test_what_cannot_be_hidden_is_refused(asked, says):
    with pytest.raises(UserError, match=says):
        hide(asked, 1, PROFILE)


def test_a_profile_may_hide_something_itself():
    entry = {"effect": "spring", "joint": 2, "k": 12.0}
    own = PROFILE.model_copy(update={"simulation": Simulation(options={"effects": [entry]})})
    assert hide(None, 1, own).effects == (entry,)


def test_a_foreign_plant_keeps_its_secret():
    profile = foreign_profile(seed=3)
    assert hide(None, 1, profile) == Hidden(foreign=True)
    with pytest.raises(UserError, match="brings a plant of its own"):
        hide("stribeck", 1, profile)


def test_a_foreign_plant_is_driven_as_our_own():
    """Our arm behind the plant protocol gives what the compiled run of it gives."""
    kinds = ("train_a", "valid_b")
    ours = make_runs(3, (), "none", kinds, PROFILE, seconds=1.5)[0]
    theirs = record(Hidden(foreign=True), 3, "none", foreign_profile(seed=3), 1.5)
    direct = foreign_runs(3, kinds, foreign_profile(seed=3), seconds=1.5)
    for kind in kinds:
        np.testing.assert_allclose(direct[kind].q, ours[kind].q, atol=1e-9)
        np.testing.assert_allclose(direct[kind].tau, ours[kind].tau, atol=1e-6)
        np.testing.assert_array_equal(theirs[kind].q, direct[kind].q)


@pytest.mark.long
@pytest.mark.parametrize("asked", ["stribeck:4", "load_friction:2", "none"])
def test_the_command_prints_one_document(asked, tmp_path, capsys):
    file = tmp_path / "report.html"
    arguments = ["demo", "--hide", asked, "--seed", "1", "--report", str(file), "--json"]
    assert main(["--data", str(tmp_path / "data"), *arguments]) == 0
    answer = json.loads(capsys.readouterr().out)
    hidden = None if asked == "none" else asked.split(":")[0]
    assert {"hidden", "joint", "found", "rms_before", "rms_after", "report"} <= set(answer)
    assert answer["hidden"] == hidden
    assert answer["found"] == hidden
    assert answer["right"] is True
    assert answer["report"] == str(file)
    assert file.is_file()
    if hidden:
        j = answer["joint"] - 1
        assert answer["rms_after"][j] < 0.5 * answer["rms_before"][j]
