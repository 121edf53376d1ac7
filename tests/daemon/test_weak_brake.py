"""A brake that does not hold the arm keeps its power on, and that is said to whoever asked."""

from __future__ import annotations

from dataclasses import replace

import pytest
from loops import run_apart
from weak_brake import SAYS, weak_brake

from pa10d.client import ApiError
from pa10d.control.brake_proof import Unheld, why_still_powered
from pa10d.control.told import ArmTold
from pa10d.daemon.events import Events
from pa10d.daemon.motions.power_off import leave_unpowered
from pa10d.daemon.robot.refusals import CommandRefused
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.profile import load_profile
from pa10d.services.robots import load_robot

__all__ = ["weak_brake"]
FOUND = (Unheld(1, 0.0056),)
LINE = why_still_powered(FOUND)


@pytest.fixture
def robot(tmp_path, monkeypatch):
    """Whose control process takes the load back, unless it shall not."""
    profile, arm = load_profile("pa10-sim"), load_robot("pa10-sim")[1]
    robot = RobotProcess(profile, arm, tmp_path, tmp_path, Events())
    robot._told = ArmTold(state="holding")

    async def command(do, timeout=15.0, **fields):
        assert do == "disable"
        state = {"state": "inactive"} if fields["anyway"] else {"unheld": FOUND}
        robot._told = replace(robot._told, **state)

    monkeypatch.setattr(robot, "command", command)
    return robot


def test_who_asks_is_told_which_brake_and_what_to_do(robot):
    with pytest.raises(CommandRefused) as refused:
        run_apart(robot.disable())
    assert str(refused.value) == f"disable: {LINE}"
    assert robot.document()["unheld"] == [FOUND[0].document()]
    run_apart(robot.disable(anyway=True))
    assert robot.state == "inactive"
    assert robot.document()["unheld"] == [], "nothing holds it any more"


def test_what_ends_by_itself_says_it_once(robot):
    notes = []
    for _ in range(2):
        run_apart(leave_unpowered(robot, notes))
    assert notes == [LINE]


@pytest.mark.long
def test_over_http_and_can(weak_brake):
    client = weak_brake
    assert client.enable()["state"] == "holding"
    with pytest.raises(ApiError) as refused:
        client.disable()
    assert refused.value.status == 409
    assert SAYS in str(refused.value)
    robot = client.robot()
    assert (robot["state"], robot["unheld"][0]["joint"]) == ("holding", 2)
    assert client.disable(anyway=True)["unheld"] == []
    client.wait_for_robot("fault")  # it sinks, and that is told


@pytest.mark.long
def test_an_experiment_says_it_with_its_result(weak_brake):
    client = weak_brake
    found = client.experiment("tracking", {"period": 4.0, "cycles": 1})
    assert len(found["runs"]) == 1
    assert SAYS in found["notes"][-1]
    assert client.robot()["state"] == "holding"
