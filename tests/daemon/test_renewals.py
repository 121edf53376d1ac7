"""A profile that is changed twice at once: control begins anew each time, and is wanted after."""

from __future__ import annotations

import asyncio

import pytest

from pa10d.control.told import ArmTold
from pa10d.daemon.events import Events
from pa10d.daemon.robot.refusals import CommandRefused
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.profile import load_profile
from pa10d.services.robots import load_robot


class Control:
    """Leaves the bus when it is told to, and is gone once it is ended."""

    def __init__(self, robot) -> None:
        self._robot, self.link, self.process = robot, self, self
        self.returncode = None

    async def ask(self, do, _timeout, **_fields):
        self._robot._told = ArmTold()
        return {"ok": True}

    async def end(self, _seconds):
        self._robot.control = None


@pytest.fixture
def robot(tmp_path):
    (tmp_path / "runtime").mkdir()
    profile, arm = load_profile("pa10-sim"), load_robot("pa10-sim")[1]
    one = RobotProcess(profile, arm, tmp_path, tmp_path / "runtime", Events())
    one._told = ArmTold("inactive")
    one._keepers = [None]
    one.control = Control(one)
    return one


def test_two_changes_at_once_leave_an_arm_that_is_wanted(robot):
    async def changed():
        await asyncio.sleep(0)
        return robot.profile, robot.robot

    async def both():
        return await asyncio.gather(
            robot.renew(changed), robot.renew(changed), return_exceptions=True
        )

    first, second = asyncio.run(both())
    assert first is None
    assert isinstance(second, CommandRefused)
    assert "wait until control has started" in second.answer["remedy"]
    assert robot._wanted
    assert not robot._renewing
