"""Whatever was asked for before a stop does not power or move the arm after it."""

from __future__ import annotations

import asyncio

import pytest
from loops import run_apart

from pa10d.common.errors import Stopped
from pa10d.control.told import ArmTold
from pa10d.daemon.events import Events
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.daemon.robot.stops import MOVES, Stops
from pa10d.profile import load_profile
from pa10d.services.robots import load_robot


@pytest.fixture
def robot(tmp_path):
    profile, arm = load_profile("pa10-sim"), load_robot("pa10-sim")[1]
    return RobotProcess(profile, arm, tmp_path, tmp_path, Events())


async def forever():
    await asyncio.Event().wait()


def test_what_began_before_a_stop_is_refused_and_what_begins_after_it_is_not():
    stops = Stops()
    with stops.heard_by(stops.count):
        stops.refuse()
        stops.ask()
        with pytest.raises(Stopped):
            stops.refuse()
        with stops.heard_by(stops.count):
            stops.refuse()
    stops.refuse()  # a request of its own, outside any job


def test_a_job_hears_a_stop_between_being_asked_for_and_its_first_step():
    stops = Stops()
    began = stops.count
    stops.ask()
    with stops.heard_by(began), pytest.raises(Stopped):
        stops.refuse()


def test_a_computation_is_left_at_once():
    async def stopped():
        stops = Stops()
        asyncio.get_running_loop().call_later(0.01, stops.ask)
        with stops.heard_by(stops.count):
            await asyncio.wait_for(stops.unless(forever()), 5.0)

    with pytest.raises(Stopped):
        run_apart(stopped())


def test_a_computation_that_nobody_stops_gives_its_result():
    async def through():
        async def three():
            return 3

        return await Stops().unless(three())

    assert run_apart(through()) == 3


@pytest.mark.parametrize("do", MOVES)
def test_the_robot_refuses_every_command_that_moves(do, robot):
    async def asked():
        with robot.stops.heard_by(robot.stops.count):
            robot.stops.ask()
            await robot.command(do)

    with pytest.raises(Stopped):
        run_apart(asked())


def test_a_stop_by_a_signal_is_one_too(robot):
    async def heard(signals):
        robot._heard(ArmTold("inactive", signals=signals).document())

    run_apart(heard(0))
    assert robot.stops.count == 0
    run_apart(heard(1))
    assert robot.stops.count == 1
    run_apart(heard(1))
    assert robot.stops.count == 1
