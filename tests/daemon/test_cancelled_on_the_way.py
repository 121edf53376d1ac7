"""A job that is cancelled while its command is on the way to control: whatever control makes of it,
the arm stops; nobody has told the daemon yet that it is powered or moves."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace

import numpy as np
import pytest
from loops import run_apart

from pa10d.control.told import ArmTold
from pa10d.daemon.events import Events
from pa10d.daemon.motions.experiment import Experiment
from pa10d.daemon.motions.way_back import bring_inside
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.experiments.prepared import PlannedMotion
from pa10d.experiments.request import MotionRequest
from pa10d.profile import load_profile
from pa10d.services.robots import load_robot


class SlowPipe:
    """To a control process that answers nothing for now."""

    def __init__(self):
        self.heard = []
        self.asked = asyncio.Event()

    def tell(self, do):
        self.heard.append(do)

    async def ask(self, do, _timeout, **_fields):
        self.heard.append(do)
        self.asked.set()
        await asyncio.Event().wait()


@pytest.fixture
def robot(tmp_path):
    profile, arm = load_profile("pa10-sim"), load_robot("pa10-sim")[1]
    return RobotProcess(profile, arm, tmp_path, tmp_path, Events())


async def cancelled_on_the_way(robot, work):
    """→ what control heard, in its order."""
    pipe = SlowPipe()
    robot.control = SimpleNamespace(link=pipe)
    task = asyncio.ensure_future(work())
    await asyncio.wait_for(pipe.asked.wait(), 10.0)
    task.cancel()
    await asyncio.wait([task])
    return pipe.heard


def experiment(robot, tmp_path):
    daemon = SimpleNamespace(robot=robot, runtime=tmp_path)
    return Experiment(daemon, MotionRequest("tracking"), lambda *_: None)


def test_an_arm_on_its_way_to_power(robot, tmp_path):
    robot._told = ArmTold(state="inactive")
    made = experiment(robot, tmp_path)
    heard = run_apart(cancelled_on_the_way(robot, lambda: made._power_up(None)))
    assert heard == ["enable", "stop"]


def test_an_arm_on_its_way_to_move(robot, tmp_path):
    async def announce(**_fields):
        return {"run": {"id": "one"}}

    async def withdraw():
        return True

    robot._told = ArmTold(state="holding")
    robot.recorder = SimpleNamespace(announce=announce, withdraw=withdraw)
    np.save(tmp_path / "rows.npy", np.zeros((20, 28)))
    motion = PlannedMotion(str(tmp_path / "rows.npy"), "plan.json", 0, 10, 20, 0.02)
    made = experiment(robot, tmp_path)
    heard = run_apart(cancelled_on_the_way(robot, lambda: made._run(motion, None, print)))
    assert heard == ["run", "stop"]


def test_an_arm_on_its_way_back_inside(robot, tmp_path, monkeypatch):
    async def plan(*_):
        return 10

    monkeypatch.setattr("pa10d.daemon.motions.way_back._plan", plan)
    robot._told = ArmTold(state="inactive")
    robot.outside, robot.pose = lambda: [1], lambda: np.zeros(7)
    daemon = SimpleNamespace(robot=robot, runtime=tmp_path)
    heard = run_apart(cancelled_on_the_way(robot, lambda: bring_inside(daemon)))
    assert heard == ["enable", "stop"]


def test_a_motion_that_has_begun_and_was_not_told_goes_no_further_without_its_recorder(robot):
    robot._told = ArmTold(state="holding")
    heard = []
    robot.control = SimpleNamespace(link=SimpleNamespace(tell=heard.append))
    robot._recorder_lost()
    assert heard == ["stop"]
