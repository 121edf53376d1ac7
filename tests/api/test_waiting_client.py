"""A client that waits for an arm: what time alone mends is waited for, the rest is said."""

from __future__ import annotations

import time

import pytest

from pa10d.client import Client
from pa10d.common.errors import UserError
from pa10d.daemon.offline import AGAIN, RENEWED, STARTING, passes


class Offline(Client):
    """Offline for a reason, over and over, on a clock of its own."""

    def __init__(self, reason: str, clock: list[float]) -> None:
        self._reason, self._clock = reason, clock

    def robot(self) -> dict:
        self._clock[0] += 1.0
        return {"state": "offline", "offline_reason": self._reason, "fault": None}


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time, "sleep", lambda seconds: None)
    return now


def test_a_drive_that_contradicts_the_profile_is_not_waited_out(clock: list[float]) -> None:
    with pytest.raises(UserError, match=r"the arm is offline, expected inactive; .*0x6076"):
        Offline("joint 1: node 1: 0x6076", clock).wait_for_robot("inactive", timeout=180.0)
    assert clock[0] < 30.0


@pytest.mark.parametrize("reason", [STARTING, RENEWED, f"the control process was killed; {AGAIN}"])
def test_what_the_daemon_does_itself_is_waited_for(reason: str, clock: list[float]) -> None:
    assert passes(reason)
    with pytest.raises(UserError, match="expected inactive"):
        Offline(reason, clock).wait_for_robot("inactive", timeout=180.0)
    assert clock[0] > 180.0
