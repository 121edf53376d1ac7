"""The user's whole sentence over HTTP and CAN: record, identify, diagnose, add, error falls."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import yaml

from pa10d.client import Client, local_daemon
from pa10d.profile import find_profile

pytestmark = [pytest.mark.long, pytest.mark.timeout(900)]
HERE = Path(__file__).resolve().parent

HIDDEN = {
    "stribeck": {"joint": 4, "Fs": 4.0, "vs": 0.1},
    "spring": {"joint": 2, "k": 12.0},
    "load_friction": {"joint": 2, "mu": 0.12},
    "torque_ripple": {"joint": 4, "order": 50, "amplitude": 2.0},
}


@dataclass
class Story:
    """An arm that has been recorded."""

    arm: Client
    fit: list[str]
    validate: list[str]


def profile_with(folder: Path, **simulation) -> Path:
    """The simulated arm, hiding something."""
    base = find_profile("pa10-sim")
    profile = yaml.safe_load(base.read_text())
    profile["urdf"] = str(base.parent / profile["urdf"])
    profile["simulation"] |= simulation
    path = folder / "arm.yaml"
    path.write_text(yaml.safe_dump(profile))
    return path


def recorded(arm: Client) -> Story:
    fit = arm.experiment("excitation", {})["runs"] + arm.experiment("velocity_sweep", {})["runs"]
    validate = arm.experiment("point_to_point", {"seed": 7})["runs"]
    validate += arm.experiment("excitation", {"seed": 9})["runs"]
    arm.identify(fit, "textbook")
    return Story(arm, fit, validate)


def options(name=None, **values):
    effects = [{"effect": name, **values}] if name else []
    return {"options": {"effects": effects, "dynamics": {"spread": 0.2, "seed": 5}, "seed": 3}}


@pytest.mark.parametrize("name", HIDDEN)
def test_a_hidden_effect_is_named_and_the_error_falls(tmp_path, name):
    path = profile_with(tmp_path, **options(name, **HIDDEN[name]))
    with local_daemon(tmp_path / "data", str(path), clock="simulated") as arm:
        story = recorded(arm)
        found = arm.diagnose("textbook", story.fit, story.validate)
        assert found["verdict"] == "missing"
        first = found["findings"][0]
        assert (first["effect"], first["joints"]) == (name, [HIDDEN[name]["joint"]])
        arm.add("textbook", first["effect"], first["joints"], story.fit, "better")
        before = arm.compare("textbook", story.validate)["pooled"]["rms"]
        after = arm.compare("better", story.validate)["pooled"]["rms"]
        joint = HIDDEN[name]["joint"] - 1
        assert after[joint] < 0.8 * before[joint]


def test_a_clean_arm_hides_nothing(tmp_path):
    path = profile_with(tmp_path, **options())
    with local_daemon(tmp_path / "data", str(path), clock="simulated") as arm:
        story = recorded(arm)
        found = arm.diagnose("textbook", story.fit, story.validate)
        assert (found["verdict"], found["findings"], found["unexplained"]) == ("none", [], [])


def test_a_foreign_plant_is_understood(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", f"{HERE}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    path = profile_with(tmp_path, plant="foreign_plant:make", options={})
    with local_daemon(tmp_path / "data", str(path), clock="simulated") as arm:
        story = recorded(arm)
        found = arm.diagnose("textbook", story.fit, story.validate)
        named = [(f["effect"], f["joints"]) for f in found["findings"]]
        assert named[:1] == [("stribeck", [4])], named
        finding = found["findings"][0]
        assert finding["rms_after"][3] < 0.5 * finding["rms_before"][3]


def test_a_doubt_is_settled_by_the_experiment_that_the_diagnosis_asks_for(tmp_path):
    """A short run in one place cannot tell where the friction comes from; the arm finds out."""
    path = profile_with(tmp_path, **options("load_friction", **HIDDEN["load_friction"]))
    with local_daemon(tmp_path / "data", str(path), clock="simulated") as arm:
        fit = arm.experiment("excitation", {"seconds": 10.0})["runs"]
        fit += arm.experiment("velocity_sweep", {"joints": [2], "count": 3})["runs"]
        arm.identify(fit, "textbook")
        alone = arm.diagnose("textbook", fit)
        doubt = [f for f in alone["findings"] if f["next_experiment"]]
        made = arm.improve("textbook", fit, "better", experiments=True)
        assert bool(made["experiments"]) == bool(doubt)
        assert ("load_friction", [2]) in [(f["effect"], f["joints"]) for f in made["findings"]]
        assert made["experiments"], "the first look was not in doubt: the test shows nothing"


def test_computed_torque_with_what_was_learnt_tracks_better(tmp_path):
    path = profile_with(tmp_path, **options())
    with local_daemon(tmp_path / "data", str(path), clock="simulated") as arm:
        arm.identify(arm.experiment("excitation", {})["runs"], "m")
        errors = {}
        for controller, model in (("pid", None), ("computed_torque", "m")):
            more = {"controller": controller} | ({"model": model} if model else {})
            found = arm.experiment("tracking", {"cycles": 2}, name=controller, **more)
            errors[controller] = np.array(found["analysis"][controller]["tracking_rms"])
        assert np.all(errors["computed_torque"] < 0.5 * errors["pid"])
