"""A profile written by hand: what Tune would have asked about is said before the arm moves."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace

import pytest

from pa10d.common.errors import Stopped
from pa10d.daemon.check import carrying_checks
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.events import Events
from pa10d.daemon.robot.refusals import CommandRefused
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.dynamics import robot_from_profile
from pa10d.profile import Gains, Tool, load_profile
from pa10d.profile.profile import Limits
from pa10d.services.robots import load_robot, shipped_robots
from pa10d.services.tuning.arm import Tuned
from pa10d.services.tuning.by_hand import gain_checks, range_checks, why_not_held

PROFILE = load_profile("pa10-sim")
ABSURD = {"kp": {"kp": [1e8] * 7}, "ki": {"ki": [1e8] * 7}, "kd": {"kd": [0.0] * 7}}


def with_gains(**gains):
    control = PROFILE.control.model_copy(update={"gains": Gains(**gains)})
    return PROFILE.model_copy(update={"control": control})


def tuned(profile):
    return Tuned(profile, robot_from_profile(profile), None)


@pytest.mark.parametrize("key", ABSURD)
def test_gains_that_hold_nothing_are_an_error_by_joint(key):
    found = gain_checks(tuned(with_gains(**ABSURD[key])))
    assert [(one.level, one.joint) for one in found] == [("error", j) for j in range(1, 8)]
    assert "joint 7: with these gains its loop is not stable in the worst pose" in found[6].sentence


def test_gains_that_swing_for_long_are_a_warning():
    (found,) = [one for one in gain_checks(tuned(with_gains(kp=[2000.0] * 7))) if one.joint == 3]
    assert found.level == "warning"
    assert "more than 3 swings for long" in found.sentence


def test_what_a_rule_gives_is_not_judged_and_may_be_stated():
    rule = tuned(PROFILE).gains
    same = with_gains(kp=rule.kp.tolist(), ki=rule.ki.tolist(), kd=rule.kd.tolist())
    assert gain_checks(tuned(PROFILE)) == gain_checks(tuned(same)) == []


def test_gains_in_force_count_whatever_the_file_says_by_now(tmp_path):
    why = why_not_held(str(tmp_path), "pa10-sim", ABSURD["kd"])
    assert why.startswith(
        "joints 1 to 7: the gains that the profile states make a loop that is not"
    )
    assert "leave control.gains out" in why
    assert "\n" not in why
    assert why_not_held(str(tmp_path), "pa10-sim", {}) is None


def test_the_shipped_arms_have_nothing_to_be_asked_about():
    for one in shipped_robots():
        profile, robot = load_robot(one["name"])
        known = Tuned(profile, robot, None)
        assert [*range_checks(known), *gain_checks(known), *carrying_checks(robot)] == []


def test_position_limits_beyond_the_urdf_are_a_warning_each():
    wide = PROFILE.model_copy(update={"limits": Limits(position=[(-1e9, 1e9)] * 7)})
    found = range_checks(tuned(wide))
    assert {one.level for one in found} == {"warning"}
    assert len(found) >= 7
    assert "lower position of -1e+09 rad goes beyond the URDF's" in found[0].sentence


def test_a_load_that_no_joint_can_hold_is_said():
    robot = robot_from_profile(PROFILE.model_copy(update={"tool": Tool(mass=1e3)}))
    found = carrying_checks(robot)
    assert found
    assert {one.level for one in found} == {"warning"}, "upright, nothing has to be held"
    assert "standing still in its worst pose, joint 2 needs" in found[0].sentence
    bent = robot_from_profile(
        PROFILE.model_copy(update={"tool": Tool(mass=1e3), "home": [0, 1.0, 0, 1.0, 0, 0, 0]})
    )
    assert next(one.joint for one in carrying_checks(bent) if one.level == "error") == 2


@pytest.fixture
def robot(tmp_path):
    made = RobotProcess(PROFILE, robot_from_profile(PROFILE), tmp_path, tmp_path, Events())
    made.asked = []

    async def ask(do, timeout, **fields):
        made.asked.append(do)
        return {"ok": True}

    made.control = SimpleNamespace(link=SimpleNamespace(ask=ask))
    return made


def test_an_arm_that_they_would_not_hold_is_not_powered(robot):
    async def would_swing():
        return "joint 1: swings"

    robot.not_held = would_swing
    with pytest.raises(CommandRefused, match="enable: joint 1: swings"):
        asyncio.run(robot.enable())
    assert robot.asked == []


def test_a_stop_while_that_is_looked_at_is_heard(robot):
    async def long_look():
        robot.stops.ask()
        await asyncio.sleep(60)

    robot.not_held = long_look
    with pytest.raises(Stopped):
        asyncio.run(robot.enable())
    assert robot.asked == []


def test_the_daemon_looks_once_at_what_it_serves(tmp_path):
    async def main():
        profile = with_gains(**ABSURD["kp"])
        daemon = Daemon(profile, robot_from_profile(profile), tmp_path, tmp_path, simulator=False)
        asked = []

        async def tuning(task, gains):
            asked.append((task, gains["kp"][0]))
            return "no"

        daemon.tuning = tuning
        assert [await daemon.robot.not_held() for _ in range(2)] == ["no", "no"]
        assert asked == [("why_not_held", 1e8)]
        daemon.profile = PROFILE
        assert await daemon.robot.not_held() is None
        assert len(asked) == 1

    asyncio.run(main())
