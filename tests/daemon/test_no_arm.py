"""A virtual arm that cannot be: told as what it is, not as a cable that is off."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from types import SimpleNamespace

import pytest
import yaml

from backends.arm_lock import arm_lock
from pa10d.common.errors import UserError
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.events import Events
from pa10d.daemon.offline import passes
from pa10d.daemon.processes import simulator as simulators
from pa10d.daemon.processes.simulator import Simulator, refuse_no_arm
from pa10d.daemon.robot.refusals import CommandRefused, no_virtual_arm
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.dynamics import robot_from_profile
from pa10d.profile import find_profile, load_profile

SWAPPED = ["S2", "S1", "S3", "E1", "E2", "W1", "W2"]
WRONG = {
    "order of joints": (
        {"joints": SWAPPED},
        "arm.yaml: joints: found S2, S1, .*, expected from base to tip",
    ),
    "no such plant": (
        {"simulation": {"plant": "os:nothing"}},
        "arm.yaml: simulation.plant: 'os:nothing': os has no 'nothing'",
    ),
    "no plant": (
        {"simulation": {"plant": "os:getpriority"}},
        r"arm.yaml: simulation.plant: 'os:getpriority': TypeError: .*; expected a plant",
    ),
    "unknown option": (
        {"simulation": {"options": {"zzz": 1}}},
        r"arm.yaml: simulation.options.zzz: found an unknown key, expected one of effects, noise",
    ),
}


FIRST, *OTHERS = WRONG
ONE = pytest.mark.parametrize(
    "wrong",
    [FIRST, *(pytest.param(name, marks=pytest.mark.long) for name in OTHERS)],
    indirect=True,
)
"""Each is refused by the same function; that its line gets out of a process is shown of one."""


@pytest.fixture(params=WRONG)
def wrong(request, tmp_path):
    """File of a profile, and what is said of it."""
    base = find_profile("pa10-sim")
    profile = yaml.safe_load(base.read_text())
    profile["urdf"] = str(base.parent / profile["urdf"])
    profile["can"]["channel"] = f"no-arm-{os.getpid()}"
    changes, says = WRONG[request.param]
    for key, value in changes.items():
        profile[key] = {**profile[key], **value} if isinstance(value, dict) else value
    path = tmp_path / "arm.yaml"
    path.write_text(yaml.safe_dump(profile))
    return path, says


def test_it_is_refused_before_anything_is_started_in_one_line(wrong):
    path, says = wrong
    with pytest.raises(UserError, match=says) as refused:
        refuse_no_arm(load_profile(path))
    assert "\n" not in str(refused.value)


@pytest.mark.long
@ONE
def test_serve_says_that_line_and_ends(wrong, tmp_path):
    path, says = wrong
    command = [sys.executable, "-m", "pa10d", "--data", str(tmp_path / "data"), "serve"]
    command += ["--port", "0", "--clock", "simulated", "--profile", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 1
    with pytest.raises(UserError, match=says):
        raise UserError(done.stderr)
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.long
@ONE
def test_the_simulators_own_line_is_heard(wrong):
    path, says = wrong
    arm = Simulator(load_profile(path))

    async def main():
        await arm.start()
        await arm.close()
        await asyncio.sleep(0.05)  # for its pipes to be closed

    asyncio.run(main())
    with pytest.raises(UserError, match=says):
        raise UserError(arm.refusal)
    with pytest.raises(UserError, match=says), simulators.simulated_bus(load_profile(path)):
        pass


def test_what_a_plant_prints_is_not_taken_for_its_word():
    async def main():
        said = asyncio.StreamReader()
        said.feed_data(b"compiled in 3 s\nready\n")
        assert await simulators._heard(said) is None
        said.feed_data(b"hm\nrefused: no such joint\n")
        assert await simulators._heard(said) == "no such joint"
        said.feed_eof()
        assert await simulators._heard(said) == simulators.SILENT

    asyncio.run(main())


def test_an_arm_that_takes_longer_than_is_waited_is_used_once_it_is_there(monkeypatch):
    """On a slow machine its first start compiles for minutes."""

    async def begun():
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-c", "input(); print('ready', flush=True); input()",
            stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
        )  # fmt: skip
        return process, os.open(os.devnull, os.O_RDONLY)

    monkeypatch.setattr(simulators, "_begun", begun)
    monkeypatch.setattr(simulators, "START_TIME", 0.05)
    monkeypatch.setattr(asyncio.StreamWriter, "close", lambda self: None)
    profile = load_profile("pa10-sim")
    can = profile.can.model_copy(update={"channel": f"slow-{os.getpid()}"})

    async def main():
        arm = Simulator(profile.model_copy(update={"can": can}))
        await arm.start()
        assert passes(arm.refusal), "nobody has to change anything"
        assert no_virtual_arm("connect", "offline", arm.refusal)["detail"].endswith(arm.refusal)
        arm.process.stdin.write(b"\n")
        await asyncio.wait([arm._hearing])
        assert arm.refusal is None
        await arm.close()
        assert arm.refusal is None

    asyncio.run(main())


def test_the_arm_is_offline_for_that_reason_and_the_log_says_when_it_is_there(tmp_path, caplog):
    profile = load_profile("pa10-sim")
    robot = RobotProcess(profile, robot_from_profile(profile), tmp_path, tmp_path, Events())
    robot.control = SimpleNamespace()
    robot.no_arm = lambda: "arm.yaml: no plant"
    with pytest.raises(CommandRefused):
        asyncio.run(robot.connect())
    assert robot.why_offline == "there is no virtual arm: arm.yaml: no plant"
    assert not robot.document()["offline_passes"]

    async def answers(do, **fields):
        return {"ok": True}

    robot.no_arm, robot.command = lambda: None, answers
    for _ in range(2):
        asyncio.run(robot.connect())
    offline, there = caplog.messages
    assert offline == f"the arm is offline: {robot.why_offline}"
    assert there == "the arm is there: its drives answer"


def test_a_daemon_tells_its_robot_what_its_simulator_said(tmp_path):
    async def main():
        profile = load_profile("pa10-sim")
        daemon = Daemon(profile, robot_from_profile(profile), tmp_path, tmp_path)
        assert daemon.robot.no_arm() is None
        daemon.simulator.refusal = "no plant"
        assert daemon.robot.no_arm() == "no plant"

    asyncio.run(main())


def test_serve_does_not_use_the_arm_of_another_daemon(tmp_path):
    profile = load_profile("pa10-sim")
    channel = f"of-others-{os.getpid()}"
    can = profile.can.model_copy(update={"channel": channel})
    command = [sys.executable, "-m", "pa10d", "--data", str(tmp_path), "serve", "--port", "0"]
    command += ["--clock", "simulated", "--channel", channel, "--hide", "stribeck:4"]
    with arm_lock(profile.model_copy(update={"can": can}), daemon=os.getpid()):
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 1
    assert f"is of another daemon, process {os.getpid()};" in done.stderr
    assert done.stderr.rstrip().endswith("--channel NAME for an arm of its own")
    assert not (tmp_path / "hidden_arm.json").exists()
