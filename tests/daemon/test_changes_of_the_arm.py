"""Profile and virtual arm are changed one at a time, while nothing moves."""

from __future__ import annotations

import asyncio
import json

import pytest
from known_joints import known_joints

from pa10d.api.problems import Problem
from pa10d.api.routes.ready import require_ready
from pa10d.common.errors import UserError
from pa10d.control.told import ArmTold
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.robot.refusals import CommandRefused
from pa10d.demo.hidden import hide, with_secret
from pa10d.dynamics import robot_from_profile
from pa10d.identify.scale import Body
from pa10d.profile import load_profile
from pa10d.services.joints import keep_learnt

PROFILE = load_profile("pa10-sim")
WEIGHT = Body.of("3,0.05,0,0.1")


class VirtualArm:
    """Becomes another one once it may; ``profiles`` that it was."""

    dead = None

    def __init__(self):
        self.profiles, self.may = [], asyncio.Event()
        self.may.set()

    def refuse_unless_own(self):
        pass

    async def become(self, profile):
        await self.may.wait()
        self.profiles.append(profile)


class Bus:
    """What the daemon asks of its robot while it switches the arm."""

    def __init__(self, monkeypatch, robot):
        self.said, self.answers = [], True
        monkeypatch.setattr(robot, "_told", ArmTold("inactive"))
        monkeypatch.setattr(robot, "until", self._nothing)
        monkeypatch.setattr(robot, "connect", self._connect)
        monkeypatch.setattr(robot, "disconnect", self._disconnect)

    async def _nothing(self, *_, **__):
        pass

    async def _disconnect(self):
        self.said.append("disconnect")

    async def _connect(self):
        self.said.append("connect")
        if not self.answers:
            raise CommandRefused({"detail": "connect: no drive answers"})


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A daemon, its virtual arm and its bus; nothing of it was started."""

    def make(profile=PROFILE):
        (tmp_path / "data").mkdir(exist_ok=True)
        robot = robot_from_profile(profile)
        daemon = Daemon(profile, robot, tmp_path / "data", tmp_path, simulator=False)
        daemon.simulator = VirtualArm()
        return daemon, daemon.simulator, Bus(monkeypatch, daemon.robot)

    return make


def test_while_one_request_changes_the_profile_others_are_refused(made, monkeypatch):
    async def main():
        daemon, _, _ = made()
        written, go_on = [], asyncio.Event()

        async def look(task, **more):
            written.append(task)
            await go_on.wait()
            return {"file": str(PROFILE.path), "version": 2}

        monkeypatch.setattr(daemon, "look", look)
        require_ready(daemon)
        first = asyncio.create_task(daemon.tune(False, "write"))
        while not written:
            await asyncio.sleep(0)
        with pytest.raises(UserError, match="is being changed"):
            await daemon.tune(False, "write")
        with pytest.raises(Problem, match="is being changed"):
            require_ready(daemon)
        go_on.set()
        assert (await first)["version"] == 2
        require_ready(daemon)
        assert (await daemon.tune(False, "write"))["version"] == 2
        assert written == ["write", "write"]

    asyncio.run(main())


@pytest.fixture
def mine(tmp_path):
    """A profile of one's own, and its text."""
    text = PROFILE.path.read_text().replace("urdf: ", f"urdf: {PROFILE.path.parent}/", 1)
    path = tmp_path / "pa10-sim.yaml"
    path.write_text(text)
    return path, text


def test_what_was_written_by_hand_does_not_go_into_force_unsaid(made, monkeypatch, mine):
    path, text = mine

    async def main():
        daemon, _, _ = made(load_profile(path))
        written = []

        async def look(task, **more):
            written.append(task)
            return {"file": str(path), "version": 2}

        monkeypatch.setattr(daemon, "look", look)
        path.write_text(text.replace("floor: 0 ", "floor: -0.5 "))
        with pytest.raises(UserError, match=r"pa10-sim\.yaml: environment changed since"):
            await daemon.tune(False, "write")
        assert written == []
        path.write_text(f"{text}map: ['t=time']\n")  # of no matter to the arm
        await daemon.tune(False, "write")
        assert written == ["write"]

    asyncio.run(main())


def test_what_moves_the_arm_is_named(made):
    async def main():
        daemon, _, _ = made()

        begun = asyncio.Event()

        async def work(report):
            begun.set()
            await asyncio.Event().wait()

        job = daemon.jobs.start("series", {}, work)
        await begun.wait()
        with pytest.raises(UserError, match="a job that moves the arm is running: series"):
            await daemon.tune(True, "write")
        with pytest.raises(Problem, match="a job that moves the arm is running: series"):
            require_ready(daemon)
        await daemon.jobs.cancel(job)
        require_ready(daemon)

    asyncio.run(main())


def test_a_weight_hangs_though_the_arm_did_not_come_back(made):
    async def main():
        daemon, arm, bus = made()
        bus.answers = False
        with pytest.raises(CommandRefused):
            await daemon.hang(WEIGHT)
        (note,) = daemon.robot.document()["notes"]
        assert "a weight hangs on the virtual arm: 3 kg" in note
        bus.answers = True
        await daemon.hang(None)
        assert [profile is PROFILE for profile in arm.profiles] == [False, True]
        assert daemon.robot.document()["notes"] == []

    asyncio.run(main())


def test_nothing_moves_while_the_virtual_arm_is_exchanged(made):
    async def main():
        daemon, arm, bus = made()
        arm.may.clear()
        asked = asyncio.create_task(daemon.hang(WEIGHT))
        while not bus.said:
            await asyncio.sleep(0)
        with pytest.raises(Problem, match="is being changed"):
            require_ready(daemon)
        with pytest.raises(UserError, match="is being changed"):
            await daemon.tune(True, "write")
        arm.may.set()
        await asked
        require_ready(daemon)

    asyncio.run(main())


def test_an_arm_that_hides_something_remembers_its_joints(made, tmp_path):
    """A daemon of a hiding arm that was started again used the rule's gains, while its tables told
    the measured ones."""
    n = len(robot_from_profile(PROFILE).joint_names)
    kept = keep_learnt(tmp_path / "data", PROFILE, ["a"], known_joints(kd=7.0, n=n))
    hiding = with_secret(PROFILE, hide("stribeck:4", 3, PROFILE), 3)
    daemon, _, _ = made(hiding)
    assert daemon.robot.joints.document() == kept.document()
    handed = json.loads((tmp_path / "profile.json").read_text())  # to every control process
    assert handed["control"]["gains"]["kd"] == n * [7.0]
