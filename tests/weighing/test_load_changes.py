"""The virtual arm gets its weight whole, or keeps what it had, also where whoever asked leaves."""

from __future__ import annotations

import asyncio

import pytest

from pa10d.common.errors import UserError
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.processes.simulator import Simulator
from pa10d.identify.scale import Body
from pa10d.profile import load_profile

WEIGHT = Body.of("3,0,0,0.08")


class Robot:
    """Connected or not; every answer takes a turn of the event loop."""

    def __init__(self) -> None:
        self.state = "inactive"

    async def disconnect(self):
        await asyncio.sleep(0)
        self.state = "offline"

    async def connect(self):
        await asyncio.sleep(0)
        self.state = "inactive"

    async def until(self, *_states, timeout):
        await asyncio.sleep(0)


class Arm(Simulator):
    """Its process ends and begins at once."""

    def __init__(self, profile) -> None:
        super().__init__(profile)
        self.process = object()

    async def start(self):
        await asyncio.sleep(0)
        self.process = object()

    async def _end(self, process):
        await asyncio.sleep(0)

    def weights(self):
        return [one["mass"] for one in self._profile.simulation.options.get("effects", ())]


@pytest.fixture
def daemon():
    one = Daemon.__new__(Daemon)
    one._arm, one._hung = load_profile("pa10-sim"), None
    one._changing = asyncio.Lock()
    one.robot, one.simulator = Robot(), Arm(one._arm)
    return one


def cancelled_after(turns, daemon, body):
    async def hang_and_leave():
        asked = asyncio.ensure_future(daemon.hang(body))
        for _ in range(turns):
            await asyncio.sleep(0)
        asked.cancel()
        await asyncio.wait([asked])

    asyncio.run(hang_and_leave())


@pytest.mark.parametrize("turns", range(9))
def test_a_weighing_that_is_cancelled_leaves_a_whole_arm(daemon, turns):
    cancelled_after(turns, daemon, WEIGHT)
    assert daemon.robot.state == "inactive"
    assert daemon.simulator.process is not None
    assert len(daemon.simulator.weights()) == (daemon._hung is not None)
    asyncio.run(daemon.hang(None))
    assert daemon.simulator.weights() == []


def test_an_arm_of_somebody_else_stays_connected(daemon):
    daemon.simulator.process = None
    with pytest.raises(UserError, match="started by somebody else"):
        asyncio.run(daemon.hang(WEIGHT))
    assert daemon.robot.state == "inactive"
