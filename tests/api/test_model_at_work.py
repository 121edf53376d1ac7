"""A model, with its effects, in the loop of a running arm: through API and command line."""

from __future__ import annotations

import json

import numpy as np
import pytest
import yaml

from pa10d.cli import main
from pa10d.client import ApiError, local_daemon
from pa10d.profile import find_profile

SINES = {"period": 6.0, "cycles": 1, "joints": [1, 2, 3, 4]}


@pytest.fixture(scope="module")
def sticky(tmp_path_factory):
    """One that hides much friction at low speed in joint 4."""
    folder = tmp_path_factory.mktemp("at-work")
    base = find_profile("pa10-sim")
    profile = yaml.safe_load(base.read_text())
    effects = [{"effect": "stribeck", "joint": 4, "Fs": 4.0, "vs": 0.15}]
    profile["urdf"] = str(base.parent / profile["urdf"])
    profile["simulation"] |= {"options": {"effects": effects, "noise": "white"}}
    path = folder / "arm.yaml"
    path.write_text(yaml.safe_dump(profile))
    with local_daemon(folder / "data", str(path), clock="simulated") as client:
        client.data = folder / "data"
        yield client


def error_of(arm, name, **options) -> np.ndarray:
    found = arm.experiment("tracking", SINES, name=name, **options)
    return np.array(found["analysis"][name]["tracking_rms"][:4])


def cli(arm, capsys, *arguments) -> dict:
    assert main(["--data", str(arm.data), "--json", *arguments]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.long
@pytest.mark.timeout(400)
def test_a_model_with_its_effects_goes_back_to_work(sticky, capsys):
    runs = sticky.experiment("excitation", {"cycles": 1, "fundamental": 0.1})["runs"]
    runs += sticky.experiment("velocity_sweep", {"joints": [4], "count": 5})["runs"]
    sticky.identify(runs, "textbook", cutoff=8.0)
    sticky.add("textbook", "stribeck", [4], runs, "with-stribeck")
    assert cli(sticky, capsys, "controller")["controller"] == "pid"
    pid = error_of(sticky, "pid")

    loaded = cli(sticky, capsys, "controller", "computed_torque", "--model", "textbook")
    assert (loaded["controller"], loaded["model"]) == ("computed_torque", "textbook")
    textbook = error_of(sticky, "textbook")
    assert np.all(textbook < 0.6 * pid)

    # the effect is nothing that the loop evaluates itself: it must travel with the motion
    loaded = cli(sticky, capsys, "controller", "--model", "with-stribeck")
    assert loaded["model"] == "with-stribeck"
    complete = error_of(sticky, "complete")
    assert complete[3] < 0.7 * textbook[3]
    asked = error_of(sticky, "asked", controller="computed_torque", model="with-stribeck")
    assert asked == pytest.approx(complete, rel=0.2)

    found = cli(
        sticky, capsys, "track", "textbook", "with-stribeck", "--set", "period=6", "cycles=1"
    )
    laws = {(law["controller"], law["model"]): law["rms"][3] for law in found["laws"]}
    for law in ("feed_forward", "computed_torque"):
        assert laws[law, "with-stribeck"] < 0.5 * laws[law, "textbook"]
    assert {worth["joint"] for worth in found["worth"]} == {4}
    assert cli(sticky, capsys, "controller")["model"] == "with-stribeck"  # as it was found

    assert sticky.use_controller("pid")["model"] is None
    assert error_of(sticky, "pid again") == pytest.approx(
        pid, rel=0.2
    )  # the integral began elsewhere


def test_what_cannot_be_loaded_is_said(arm, capsys, tmp_path):
    with pytest.raises(ApiError, match="model 'nobody': none of this name"):
        arm.use_controller("computed_torque", "nobody")
    with pytest.raises(ApiError, match="expected 'model'"):
        arm.use_controller("feed_forward")
    with pytest.raises(ApiError, match="model 'nobody': none of this name"):
        arm.track(["nobody"])
    with pytest.raises(ApiError, match="a first motion is the servo's own"):
        arm.track(["nobody"], "first_motion")
    assert main(["--data", str(tmp_path), "controller", "pid"]) == 1
    assert "no daemon runs on this data" in capsys.readouterr().err
