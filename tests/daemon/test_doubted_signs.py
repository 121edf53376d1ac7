"""Of which joints the sign was doubted, kept for the control process and the daemon that come
next."""

from __future__ import annotations

import asyncio

import pytest

from pa10d.control.told import ArmTold
from pa10d.daemon.events import Events
from pa10d.daemon.robot.doubted_signs import DoubtedSigns
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.profile import load_profile
from pa10d.services.robots import load_robot

SIMULATED = load_profile("pa10-sim")
REAL = SIMULATED.model_copy(update={"simulation": None})


def noted(folder, *doubted, profile=REAL) -> None:
    async def note() -> None:
        signs = DoubtedSigns(profile, folder)
        for one in doubted:
            signs.note(one)
        await asyncio.sleep(0.05)
        signs.close()

    asyncio.run(note())


def test_it_is_there_for_the_next_daemon_until_it_is_seen_to_be_right(tmp_path):
    noted(tmp_path, (2, 5))
    assert DoubtedSigns(REAL, tmp_path).known == (2, 5)
    noted(tmp_path, (5,), ())
    assert DoubtedSigns(REAL, tmp_path).known == ()
    assert not list(tmp_path.iterdir())


def test_of_other_drives_and_of_a_virtual_arm_nothing_is_kept(tmp_path):
    noted(tmp_path, (2,), profile=SIMULATED)
    assert not list(tmp_path.iterdir())
    noted(tmp_path, (2,))
    signs = DoubtedSigns(REAL, tmp_path)
    signs.becomes(REAL.model_copy(update={"joints": list(reversed(REAL.joints))}))
    assert signs.known == ()


@pytest.mark.parametrize("damage", ["", "[1]", '{"doubted": 3}', '{"drives": 1, "doubted": ["x"]}'])
def test_what_is_damaged_is_not_known(tmp_path, damage):
    noted(tmp_path, (2,))
    (tmp_path / "doubted.json").write_text(damage)
    assert DoubtedSigns(REAL, tmp_path).known == ()


def test_control_is_told_at_its_connect(tmp_path, monkeypatch):
    """A new process says of nothing that it is in doubt until it has been told."""
    told = []

    async def story() -> None:
        robot = RobotProcess(*load_robot("pa10-sim"), tmp_path, tmp_path, Events())

        async def command(do, **fields):
            told.append(fields["doubted"])
            return {}

        monkeypatch.setattr(robot, "command", command)
        robot.bus_ready.set()
        robot._heard(ArmTold("fault", doubted=(3,)).document())
        robot._heard(ArmTold("offline").document())
        await robot._reach()
        robot._heard(ArmTold("inactive", doubted=()).document())
        await robot._reach()

    asyncio.run(story())
    assert told == [[3], []]
