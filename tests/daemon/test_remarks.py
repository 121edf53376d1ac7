"""What drives say beside their states reaches ``check`` and the robot's notes, by joint."""

from __future__ import annotations

from types import SimpleNamespace

from backends.canopen_cia402 import DEVICE
from pa10d.daemon import check
from pa10d.daemon.robot.axes import remarks_of

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
