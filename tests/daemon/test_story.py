"""The user's whole sentence over HTTP and CAN: record, identify, diagnose, add, the error falls."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from pa10d.client import JobFailed
from pa10d.demo.bench import Bench
from pa10d.demo.hidden import Hidden
from pa10d.demo.story import play
from pa10d.profile import find_profile, load_profile

PROFILE = load_profile("pa10-sim")
HERE = Path(__file__).resolve().parent
long = pytest.mark.long
pytestmark = pytest.mark.timeout(900)

STRIBECK = {"effect": "stribeck", "joint": 4, "Fs": 4.0, "vs": 0.1}
PAYLOAD = {"effect": "payload", "mass": 2.0, "cx": 0.02, "cz": 0.1}
TRAITS = [
    STRIBECK,
    {"effect": "spring", "joint": 2, "k": 12.0, "q0": 0.3},
    {"effect": "load_friction", "joint": 2, "mu": 0.12},
    {"effect": "torque_ripple", "joint": 4, "N": 50.0, "sin": 1.5},
]
CHANGES = [PAYLOAD, {"effect": "encoder_offset", "joint": 4, "offset": 0.03}]


def bench(*effects: dict, profile=PROFILE) -> Bench:
    return Bench(profile, Hidden(effects), seed=5)


def told(folder: Path, bench: Bench, hidden: Hidden):
    with bench.running(folder):
        return play(bench, hidden, 5, print, lambda share, what: None)


@pytest.mark.long
def test_what_is_missing_and_then_what_has_changed(tmp_path):
    """An arm with Stribeck friction is understood; later it holds something, and that is seen."""
    with bench(STRIBECK, PAYLOAD).running(tmp_path) as arm:
        client = arm.client
        slow = {"cycles": 1, "fundamental": 0.05, "harmonics": 4}
        fit = client.experiment("excitation", slow)["runs"]
        judge = client.experiment("point_to_point", {"count": 5})["runs"]
        client.identify(fit, "textbook")
        found = client.diagnose("textbook", fit, judge, effect="stribeck")
        assert [f["joints"] for f in found["findings"]] == [[4]]
        falls = found["findings"][0]
        assert falls["rms_after"][3] < 0.5 * falls["rms_before"][3]
        client.add("textbook", "stribeck", [4], fit, "better")
        history = client.compare("better", judge)["history"]
        assert [step["model"] for step in history] == ["textbook", "better"]
        assert history[1]["rms"][3] < 0.9 * history[0]["rms"][3], "standstill included"

        arm.time_passes()
        fit = client.experiment("point_to_point", {"count": 5, "seed": 3})["runs"]
        changed = client.diagnose("better", fit, frozen=True)
        assert [f["effect"] for f in changed["findings"]] == ["payload"]
        mass = changed["findings"][0]["parameters"]["mass"]
        assert mass["value"] == pytest.approx(2.0, abs=max(0.03, 5 * mass["std_error"]))
        for run in client.runs():
            assert b"payload" not in (tmp_path / "runs" / run["id"] / "run.mcap").read_bytes()


@long
def test_a_change_becomes_part_of_the_model(tmp_path):
    """``add`` of what a refit would swallow: the model as it was, and the payload on top."""
    with bench(PAYLOAD).running(tmp_path) as arm:
        client = arm.client
        before = client.experiment("excitation", {})["runs"]
        client.identify(before, "empty")
        arm.time_passes()
        fit = client.experiment("excitation", {"seed": 3})["runs"]
        judge = client.experiment("point_to_point", {"seed": 8})["runs"]
        client.add("empty", "payload", [], fit, "loaded")
        history = client.compare("loaded", judge)["history"]
        assert [step["model"] for step in history] == ["empty", "loaded"]
        assert history[1]["rms"][1] < 0.2 * history[0]["rms"][1]
        with pytest.raises(JobFailed, match="these runs do not show it against model 'empty'"):
            client.add("empty", "payload", [], before, "nothing")


@long
@pytest.mark.parametrize("entry", [*TRAITS, *CHANGES], ids=lambda e: e["effect"])
def test_a_hidden_effect_is_named_and_the_error_falls(tmp_path, entry):
    hidden = Hidden((entry,))
    story = told(tmp_path, bench(entry), hidden)
    answer = story.document()
    assert answer["right"] is True, answer["findings"]
    assert answer["frozen"] is (entry in CHANGES)
    falls = np.array(answer["rms_after"]) / np.array(answer["rms_before"])
    assert falls[(answer["joint"] or 2) - 1] < 0.8


@long
def test_a_doubt_is_settled_by_the_experiment_that_the_diagnosis_asks_for(tmp_path):
    """At low speed a square of the speed looks like wide Stribeck friction; a sweep tells."""
    entry = {"effect": "nonlinear_viscous", "joint": 5, "Fp": 0.2, "p": 2.0}
    with bench(entry).running(tmp_path / "data") as arm:
        client = arm.client
        slow = {"cycles": 1, "fundamental": 0.025, "harmonics": 2}
        fit = client.experiment("excitation", slow)["runs"]
        client.identify(fit, "textbook")
        doubt = client.diagnose("textbook", fit)["findings"][0]
        assert doubt["confounded_with"]
        assert doubt["next_experiment"]

        client.let_others_command()
        plan = tmp_path / "plan.json"
        plan.write_text(json.dumps(doubt["next_experiment"]))
        command = [sys.executable, "-m", "pa10d", "--data", str(tmp_path / "data"), "--json"]
        done = subprocess.run(
            [*command, "experiment", "--plan", str(plan)], text=True, capture_output=True
        )
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["kind"] == doubt["next_experiment"]["kind"]

        done = subprocess.run(
            [*command, "improve", "textbook", "--experiments", "--fit", *fit, "--name", "better"],
            text=True, capture_output=True,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        made = json.loads(done.stdout)
        assert made["experiments"][0]["plan"]["kind"] == doubt["next_experiment"]["kind"]
        first, *more = made["findings"]
        assert not more, [finding["sentence"] for finding in more]
        assert (first["effect"], first["joints"]) == ("nonlinear_viscous", [5])
        rivals = [c["effect"] for c in doubt["confounded_with"]]
        assert not {c["effect"] for c in first["confounded_with"]} & set(rivals), "settled"
        assert client.model("better")["parent_name"] == "textbook"


@long
def test_a_clean_arm_hides_nothing(tmp_path):
    answer = told(tmp_path, bench(), Hidden()).document()
    assert (answer["verdict"], answer["findings"], answer["unexplained"]) == ("none", [], [])
    assert answer["frozen"], "both questions were asked"


@pytest.fixture
def foreign(tmp_path, monkeypatch):
    """The simulated arm with a plant that nobody of the project wrote."""
    monkeypatch.setenv("PYTHONPATH", f"{HERE}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    base = find_profile("pa10-sim")
    profile = yaml.safe_load(base.read_text())
    profile["urdf"] = str(base.parent / profile["urdf"])
    profile["simulation"] |= {"plant": "foreign_plant:make", "options": {"bump": 4.0}}
    path = tmp_path / "arm.yaml"
    path.write_text(yaml.safe_dump(profile))
    return path


@long
def test_a_foreign_plant_is_understood(tmp_path, foreign):
    """By the command: nobody but the plant knows what it hides."""
    command = [sys.executable, "-m", "pa10d", "--json", "demo", "--profile", str(foreign)]
    done = subprocess.run(
        [*command, "--seed", "1"], cwd=tmp_path, text=True, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert (answer["hidden"], answer["right"]) == (None, None)
    assert (answer["found"], answer["joint"]) == ("stribeck", 4)
    assert answer["rms_after"][3] < 0.5 * answer["rms_before"][3]


@pytest.mark.long  # test_no_arm has the simulator's own line
def test_a_plant_that_cannot_be_made_is_said_in_a_line(tmp_path, foreign):
    foreign.write_text(foreign.read_text().replace("foreign_plant:make", "foreign_plant:none"))
    done = subprocess.run(
        [sys.executable, "-m", "pa10d", "demo", "--profile", str(foreign)],
        cwd=tmp_path, text=True, capture_output=True, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert "simulation.plant" in done.stderr
    assert "Traceback" not in done.stderr


@long
def test_computed_torque_with_what_was_learnt_tracks_better(tmp_path):
    with bench().running(tmp_path) as arm:
        client = arm.client
        client.identify(client.experiment("excitation", {})["runs"], "m")
        errors = {}
        for controller, model in (("pid", None), ("computed_torque", "m")):
            more = {"controller": controller} | ({"model": model} if model else {})
            found = client.experiment("tracking", {"cycles": 2}, name=controller, **more)
            errors[controller] = np.array(found["analysis"][controller]["tracking_rms"])
        assert np.all(errors["computed_torque"] < 0.5 * errors["pid"])
