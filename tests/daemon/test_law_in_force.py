"""The law that is told is the one that control has; the one that was chosen comes back."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from known_joints import measured_joints

from pa10d.daemon.events import Events
from pa10d.daemon.motions import tracking
from pa10d.daemon.processes.link import LinkClosed
from pa10d.daemon.robot.refusals import CommandRefused
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.dynamics import robot_from_profile
from pa10d.experiments.request import TrackingRequest
from pa10d.profile import load_profile

LAW = {"name": "computed_torque", "model": {"name": "m1", "parameters": 40}}
OTHER = {"name": "feed_forward", "model": {"name": "m2", "parameters": 41}}
PROFILE = load_profile("pa10-sim")


class Control:
    """The other end of the pipe: an arm that begins offline under PID, as each one does."""

    def __init__(self, robot):
        self._robot, self.link, self.pid = robot, self, 1
        self.asked, self.away, self.admits = [], False, True
        self.told = {}
        self._state, self._law = "offline", {"name": "pid"}
        robot.control = self
        self._tell()

    async def ask(self, do, timeout, **fields):
        self.asked.append(do)
        self.told[do] = fields
        if self.away:
            raise LinkClosed("the process ended")
        if do == "controller":
            if self._state not in ("inactive", "holding"):
                return self._refuses(do, f"the arm is {self._state}")
            if fields["name"] != "pid" and not self.admits:
                return self._refuses(do, "its model is far beside the torque that holds the arm")
            self._law = fields
        else:
            self._state = {"connect": "inactive", "reset": "inactive", "enable": "holding"}[do]
        self._tell()
        return {"reply": 1, "ok": True, "state": self._state}

    def fault(self):
        """Which the servo alone brings to rest."""
        self._state, self._law = "fault", {"name": "pid"}
        self._tell()

    def _refuses(self, do, why):
        detail = f"{do}: {why}"
        return {"reply": 1, "ok": False, "command": do, "state": self._state, "detail": detail}

    def _tell(self):
        model = self._law.get("model") or {}
        fault = {"kind": "stale", "cause": "lost"} if self._state == "fault" else None
        told = {"state": self._state, "fault": fault, "controller": self._law["name"]}
        self._robot._heard({"event": "state", **told, "model": model.get("name"), "warnings": []})


@pytest.fixture
def robot(tmp_path, monkeypatch):
    monkeypatch.setattr("pa10d.daemon.robot.robot.keep_fault", lambda *_: None)
    made = RobotProcess(PROFILE, robot_from_profile(PROFILE), tmp_path, tmp_path, Events())
    made.bus_ready.set()
    return made


def law_of(robot):
    document = robot.document()
    return document["controller"], document["model"], document["model_parameters"]


def test_patience_with_a_command_ends_with_its_answer(robot):
    """What hangs a moment after it was asked to enable held the arm for 75 s more."""

    async def main():
        control = Control(robot)
        robot._liveness.tick(7, commanded=True)
        await robot.connect()
        quiet = [robot._liveness.tick(7, commanded=False) for _ in range(40)]
        assert any(quiet), "20 s"
        assert control.asked == ["connect"]

    asyncio.run(main())


def test_after_a_restart_of_control_it_is_taken_up_once_the_arm_is_there(robot):
    async def main():
        Control(robot)
        await robot.connect()
        await robot.law.use(LAW, "id-1")
        assert law_of(robot) == ("computed_torque", "m1", 40)

        control = Control(robot)
        control.away = True
        with pytest.raises(CommandRefused):
            await robot.connect()
        assert law_of(robot) == ("pid", None, None)
        control.away = False
        await robot.connect()
        assert control.asked == ["connect", "connect", "controller"]
        assert law_of(robot) == ("computed_torque", "m1", 40)
        assert (robot.law.controller, robot.law.model) == (LAW, "id-1")

    asyncio.run(main())


def test_each_control_that_starts_is_told_what_the_arm_was_felt_to_weigh(robot):
    """It began with a rough URDF again, and the arm sank until it was caught."""

    async def main():
        bodies = np.arange(70.0).reshape(7, 10)
        kept = measured_joints(n=7)
        figures = kept.known.figures.but(bodies=np.stack(2 * [bodies]))
        felt = replace(kept, known=replace(kept.known, figures=figures))
        for joints, told in ((None, None), (kept, None), (felt, bodies)):
            robot.joints, control = joints, Control(robot)
            await robot.connect()
            assert control.told["connect"]["bodies"] == (None if told is None else told.tolist())

    asyncio.run(main())


def test_where_it_is_refused_the_servo_keeps_the_arm_and_a_note_says_so(robot):
    async def main():
        Control(robot)
        await robot.connect()
        await robot.law.use(LAW, "id-1")
        control = Control(robot)
        control.admits = False
        await robot.connect()
        assert law_of(robot) == ("pid", None, None)
        assert (robot.law.controller, robot.law.model) == ({"name": "pid"}, None)
        (note,) = robot.document()["notes"]
        assert note.startswith("computed_torque was not taken up again: controller: its model is")
        control.admits = True
        await robot.law.use(LAW, "id-1")
        assert robot.document()["notes"] == []

    asyncio.run(main())


def test_a_fault_leaves_the_arm_to_the_servo_until_its_reset(robot):
    async def main():
        control = Control(robot)
        await robot.connect()
        await robot.law.use(LAW, "id-1")
        control.fault()
        assert law_of(robot) == ("pid", None, None)
        await robot.reset()
        assert law_of(robot) == ("computed_torque", "m1", 40)

    asyncio.run(main())


def test_whoever_enables_the_arm_first_gets_it_too(robot):
    """Between the connection and the law."""

    async def main():
        control = Control(robot)
        await robot.connect()
        robot.law.controller, robot.law.model = LAW, "id-1"
        await robot.enable()
        assert control.asked == ["connect", "enable", "controller"]
        assert law_of(robot) == ("computed_torque", "m1", 40)

    asyncio.run(main())


@pytest.mark.parametrize("faults", [False, True])
def test_tracking_leaves_the_law_as_it_was_found(robot, monkeypatch, faults):
    async def main():
        control = Control(robot)
        await robot.connect()
        await robot.law.use(LAW, "id-1")

        async def track(daemon, request, report):
            await robot.law.use(OTHER, "id-2")
            if faults:
                control.fault()

        works = []
        monkeypatch.setattr(tracking, "_track", track)
        jobs = SimpleNamespace(start=lambda kind, request, work: works.append(work))
        tracking.tracking_job(
            SimpleNamespace(robot=robot, move=jobs.start), TrackingRequest("tracking", {}, [])
        )
        await works[0](None)
        if faults:
            assert law_of(robot) == ("pid", None, None)
            await robot.reset()
        assert law_of(robot) == ("computed_torque", "m1", 40)
        assert (robot.law.controller, robot.law.model) == (LAW, "id-1")

    asyncio.run(main())


def test_an_arm_that_was_disconnected_stays_so_when_control_begins_anew(robot):
    """Whatever law was chosen; and it does not say for ever that control is being started."""

    async def main():
        robot.law.controller, robot._wanted, robot.why_offline = LAW, False, "it is being started"
        control = Control(robot)
        ends = asyncio.Event()
        child = SimpleNamespace(process=SimpleNamespace(wait=ends.wait))
        watching = asyncio.create_task(robot._watch_control(child))
        for _ in range(10):
            await asyncio.sleep(0)
        assert control.asked == []
        assert robot.document()["offline_reason"] == "disconnected on request"
        ends.set()
        await watching

    asyncio.run(main())
