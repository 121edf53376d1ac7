"""Tuning through API and command line: refused while the arm may move, taken over at once."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pa10d.cli import main
from pa10d.client import ApiError
from pa10d.services.tuning.keys import KEYS, TuningKey

SLOW = {"limits.velocity": {"1": 0.4}}
SINES = {"amplitude": 0.3, "period": 4.0, "joints": [1]}  # needs 0.47 rad/s


@pytest.fixture(scope="module")
def mine(arm):
    """One name for HTTP and the command line."""
    yield arm
    arm.let_others_command()


def test_the_schema_names_every_key():
    assert list(TuningKey.__args__) == list(KEYS)


@pytest.mark.long
def test_an_arm_is_tuned_while_it_is_served(mine, capsys):
    before, edits = mine.tuning(), len(mine.tuning_versions())
    with pytest.raises(ApiError, match="goes beyond the URDF's 1") as asked:
        mine.tune({"limits.velocity": {"1": 1.1}})
    assert (asked.value.problem["status"], len(asked.value.problem["confirm"])) == (409, 1)
    with pytest.raises(ApiError, match=r"limits\.velocity\.1: found -1, expected a number above 0"):
        mine.tune({"limits.velocity": {"1": -1}})

    mine.enable()
    with pytest.raises(ApiError, match="the arm is holding") as refusal:
        mine.tune(SLOW)
    assert refusal.value.problem["needed"] == ["inactive", "offline"]
    floor = mine.tune({"environment.floor": -0.5}, confirmed=True)  # only plans look at it
    assert (floor["restart"], mine.robot()["state"]) == (False, "holding")
    mine.disable()

    assert mine.check_experiment({"kind": "tracking", "parameters": SINES})["go"]
    written = mine.tune(SLOW)
    assert (written["written"], written["version"]) == (True, floor["version"] + 1)
    mine.wait_for_robot("inactive", timeout=60)
    with pytest.raises(Exception, match=r"needs a speed of 0\.471 rad/s, allowed are 0\.396"):
        mine.check_experiment({"kind": "tracking", "parameters": SINES})

    mine.let_others_command()
    data = Path(written["file"]).parents[1]
    assert main(["--data", str(data), "--json", "profile", "undo"]) == 0  # by the daemon
    assert json.loads(capsys.readouterr().out)["version"] == floor["version"]
    mine.wait_for_robot("inactive", timeout=60)
    assert mine.check_experiment({"kind": "tracking", "parameters": SINES})["go"]
    mine.undo_tuning()
    assert mine.tuning()["values"] == before["values"]
    assert [one["undone"] for one in mine.tuning_versions()[: -edits or None]] == [True, True]
