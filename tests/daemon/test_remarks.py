"""What drives say beside their states reaches ``check`` and the robot's notes, by joint."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from backends.canopen_cia402 import DEVICE
from pa10d.control.faults import Fault
from pa10d.daemon import check
from pa10d.daemon.robot.axes import remarks_of
from pa10d.daemon.robot.robot import RobotProcess

QUIET, WARNS = 0x0250, 0x02D0


def test_a_drive_that_warns_is_named():
    (found,) = check._remarks(DEVICE, SimpleNamespace(statuses=lambda: [QUIET, WARNS]))
    assert (found.level, found.subject, found.joint) == ("warning", "drives", 2)
    assert found.sentence.startswith("joint 2: its drive warns (bit 7 of the statusword)")
    axes = [{"joint": 1, "status_word": WARNS}, {"joint": 2, "status_word": QUIET}]
    (note,) = remarks_of(DEVICE, axes)
    assert note.startswith("joint 1: its drive warns")


def test_a_backend_without_drives_says_nothing():
    assert check._remarks(DEVICE, SimpleNamespace()) == []


@pytest.mark.parametrize("dead", [None, "the virtual arm's process was ended by signal 9"])
@pytest.mark.parametrize("device", [True, False])
def test_drives_of_a_dead_virtual_arm_want_no_cable_looked_at(dead, device):
    """What died and how it comes back stood in a folded note, beside "power and cable"."""
    fault = Fault("silent", "no TPDO for 5 cycles", 0, "power and cable", device=device)
    robot = SimpleNamespace(fault=fault, remark=dead, state="fault")
    told = RobotProcess.brief.fget(robot)["fault"]
    assert told["remedy"] == (dead if dead and device else "power and cable")
    assert told["sentence"] == f"joint 1: no TPDO for 5 cycles; {told['remedy']}"
