"""``pa10d diagnose``, ``add``, ``improve`` on a small arm with a spring, as a user types them."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest
from importing import imported
from two_links import CUTOFF, NAMES, SECONDS, URDF, recordings

from pa10d.cli import main

STIFFNESS, CENTRE = 2.0, 0.3
FIT, VALIDATE = NAMES[:2], NAMES[2:]


def spring(t, q, dq, ddq):
    return np.column_stack([np.zeros(len(t)), STIFFNESS * (q[:, 1] - CENTRE)])


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """A data folder with four runs of the arm with the spring, two without, and a model."""
    clean = {f"clean_{k}": run for k, run in recordings(4).items()}
    folder = tmp_path_factory.mktemp("spring")
    store, profile = imported(folder, {**recordings(3, spring), **clean})
    for name, runs in (("m0", FIT), ("clean0", [f"clean_{k}" for k in FIT])):
        command = ["identify", *runs, "--profile", profile, "--name", name]
        assert main(["--data", store, *command, "--cutoff", str(CUTOFF)]) == 0
    return store


def sides(prefix=""):
    return ["--fit", *(prefix + k for k in FIT), "--validate", *(prefix + k for k in VALIDATE)]


def _is_numbers(values, n=2):
    assert len(values) == n
    assert all(isinstance(v, float) and math.isfinite(v) for v in values)


def test_diagnose_names_the_spring(run):
    status, found, _ = run("diagnose", "m0", *sides())
    assert status == 0
    assert found["verdict"] == "missing"
    assert found["headline"].startswith("Missing: spring J")
    for key in ("rms", "noise_floor"):
        _is_numbers(found[key])
    assert found["cutoff_hz"] == CUTOFF
    assert found["unexplained"] == []
    (finding,) = found["findings"]
    assert (finding["effect"], finding["joints"]) == ("spring", [2])
    assert set(finding["parameters"]) == {"k", "q0"}
    for name, truth, unit in (("k", STIFFNESS, "N·m/rad"), ("q0", CENTRE, "rad")):
        one = finding["parameters"][name]
        assert {"value", "std_error", "unit"} <= set(one)
        assert one["unit"] == unit
        assert 0 < one["std_error_random"] < 0.1
        assert one["std_error_random"] < one["std_error"] or unit == "rad"
        assert abs(one["value"] - truth) < 3.5 * one["std_error"]
    for key in ("rms_before", "rms_after"):
        _is_numbers(finding[key])
    assert finding["rms_before"] == pytest.approx(found["rms"], rel=0.05)
    assert finding["rms_after"][1] < 0.1 * finding["rms_before"][1]
    assert finding["rms_after"] == pytest.approx(found["noise_floor"], rel=0.15)
    assert 0 <= finding["p_value"] < 0.01
    assert isinstance(finding["confounded_with"], list)
    assert "next_experiment" in finding
    assert "valid_a, valid_b, which the fit has not seen" in found["judged_on"]
    assert "spring" in finding["sentence"].lower()


@pytest.mark.long  # improve, below, finds nothing there either
def test_diagnose_clears_a_clean_arm(run):
    _, found, _ = run("diagnose", "clean0", *sides("clean_"))
    assert found["verdict"] == "none"
    assert found["headline"].startswith("Nothing is missing")
    assert (found["findings"], found["unexplained"]) == ([], [])


@pytest.mark.long
def test_without_validation_the_answer_says_how_it_was_judged(run):
    _, found, _ = run("diagnose", "m0", "--fit", *FIT)
    assert "every other block of time" in found["judged_on"]
    assert found["findings"][0]["effect"] == "spring"


@pytest.mark.long
def test_a_suspicion_is_tested_alone(run):
    _, found, _ = run("diagnose", "m0", *sides(), "--effect", "spring", "--joint", "2")
    assert [(f["effect"], f["joints"]) for f in found["findings"]] == [("spring", [2])]
    _, found, _ = run("diagnose", "m0", *sides(), "--effect", "spring", "--joint", "1")
    assert (found["verdict"], found["findings"]) == ("none", [])


@pytest.mark.long  # test_changed asks the same in process
def test_frozen_tells_what_changed(run):
    """The clean model on runs with the spring: something has changed, and on joint 2."""
    _, found, _ = run("diagnose", "clean0", *sides(), "--frozen")
    assert found["frozen"] is True
    assert found["verdict"] in ("missing", "unknown")
    joints = [j for f in found["findings"] for j in f["joints"]]
    joints += [u["joint"] for u in found["unexplained"]]
    assert 2 in joints
    for u in found["unexplained"]:
        assert set(u) >= {"joint", "depends_on", "share", "rms"}
    _, same, _ = run("diagnose", "clean0", *sides("clean_"), "--frozen")
    assert same["verdict"] == "none"


def test_words_for_a_person(data, capsys):
    capsys.readouterr()
    suspicion = ["--effect", "spring", "--joint", "2"]
    assert main(["--data", data, "diagnose", "m0", *sides(), *suspicion]) == 0
    said = capsys.readouterr()
    assert "1. Joint 2 shows a spring:" in said.out
    stiffness = re.search(r"spring J2: k = ([\d.]+) ± ([\d.]+) N·m/rad", said.out)
    assert stiffness, said.out
    assert abs(float(stiffness[1]) - 2.0) < 4 * float(stiffness[2])
    assert "judged on runs valid_a, valid_b" in said.out


def test_add_makes_a_new_version_and_keeps_the_old_one(run, tmp_path):
    _, before, _ = run("model", "show", "m0")
    _, made, _ = run("add", "m0", "spring", "--joint", "2", "--fit", *FIT, "--name", "sprung")
    assert (made["name"], made["parent"], made["warnings"]) == ("sprung", "m0", [])
    _is_numbers(made["held_out"])
    _, after, _ = run("model", "show", "m0")
    assert after == before
    _, history, _ = run("model", "history", "sprung")
    assert "m0" in json.dumps(history)
    _, shown, _ = run("model", "show", "sprung")
    assert shown["feasible"], "its links are possible bodies, as those of the model before"
    out = ["--out", str(tmp_path / "sprung.urdf")]
    assert run("model", "export", "sprung", "--format", "urdf", *out)[0] == 0
    _, compared, _ = run("compare", "sprung", *VALIDATE)
    _, old, _ = run("compare", "m0", *VALIDATE)
    assert compared["pooled"]["rms"][1] < 0.1 * old["pooled"]["rms"][1]


@pytest.mark.long
def test_add_warns_where_nothing_supports_the_effect(run):
    status, made, said = run(
        "add", "clean0", "spring", "--joint", "2", "--fit", *(f"clean_{k}" for k in FIT),
        "--name", "imagined",
    )  # fmt: skip
    assert status == 0
    assert "spring J2: not significant on held-out data" in said
    assert made["warnings"]


@pytest.mark.long  # test_one_judgement improves by the command, too
def test_improve_stores_every_step(run):
    _, made, _ = run("improve", "m0", *sides(), "--name", "better")
    assert made["name"] == "better"
    assert [v["name"] for v in made["versions"]] == ["better"]
    _is_numbers(made["versions"][0]["held_out"])
    assert made["findings"][0]["effect"] == "spring"
    _, shown, _ = run("model", "show", "better")
    assert "spring" in json.dumps(shown)


@pytest.mark.long
def test_improve_of_a_complete_model_stores_nothing(run):
    _, made, _ = run("improve", "clean0", *sides("clean_"), "--name", "same")
    assert (made["id"], made["versions"], made["verdict"]) == (None, [], "none")
    assert run("model", "show", "same")[0] == 1


REFUSED = {
    "unknown effect": (
        ["diagnose", "m0", "--fit", "fit_a", "--effect", "magic"],
        "magic",
    ),
    "joint out of range": (
        ["diagnose", "m0", "--fit", "fit_a", "--effect", "spring", "--joint", "3"],
        "joint 3: expected 1 to 2",
    ),
    "joint zero": (
        ["diagnose", "m0", "--fit", "fit_a", "--effect", "spring", "--joint", "0"],
        "joint 0: expected 1 to 2",
    ),
    "a pair needs two joints": (
        ["add", "m0", "coupling_friction", "--joint", "1", "--fit", "fit_a", "--name", "x"],
        "coupling_friction: acts on a pair, expected two different joints",
    ),
    "a pair of one joint": (
        ["add", "m0", "coupling_friction", "--joint", "2", "2", "--fit", "fit_a", "--name", "x"],
        "coupling_friction: acts on a pair, expected two different joints",
    ),
    "a name that is taken": (
        ["add", "m0", "spring", "--joint", "2", "--fit", "fit_a", "--name", "clean0"],
        "clean0",
    ),
    "a name that is taken by improve": (
        ["improve", "m0", "--fit", "fit_a", "--name", "clean0"],
        "clean0",
    ),
    "no such run": (["diagnose", "m0", "--fit", "nowhere"], "nowhere"),
    "no such model": (["diagnose", "m99", "--fit", "fit_a"], "m99"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_done_is_said_in_one_line(run, case):
    arguments, expected = REFUSED[case]
    status, _, said = run(*arguments)
    assert status == 1
    lines = [line for line in said.splitlines() if expected in line]
    assert len(lines) == 1
    assert "Traceback" not in said


def test_wrong_usage_is_two(data, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["--data", data, "diagnose", "m0"])
    assert stopped.value.code == 2
    assert "--fit" in capsys.readouterr().err


def test_a_short_recording_is_refused_in_words(data, run, tmp_path):
    short = recordings(9)["fit_a"]
    rows = slice(0, int(3 * len(short.t) / SECONDS))
    file = tmp_path / "short.csv"
    columns = np.column_stack([short.t[rows], short.q[rows], short.tau[rows]])
    np.savetxt(file, columns, "%.9g", ",", header="time,q1,q2,tau1,tau2", comments="")
    profile = tmp_path / "two.yaml"
    (tmp_path / "two.urdf").write_text(URDF)
    profile.write_text("urdf: two.urdf\n")
    assert main(["--data", data, "run", "import", str(file), "--profile", str(profile)]) == 0
    status, _, said = run("diagnose", "m0", "--fit", "short")
    assert status == 1
    assert "s of motion in the data to fit, too little for the 11 unknowns of m0" in said
