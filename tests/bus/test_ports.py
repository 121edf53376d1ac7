"""A bus of python-can behind the port."""

from __future__ import annotations

import time

import can

from backends.ports import MessagePort


class Silent(can.BusABC):
    """Nobody sends; while somebody listens the wall clock is set back by an hour."""

    def __init__(self):
        super().__init__(channel=None)
        self.asked, self.back = [], 0.0

    def send(self, msg, timeout=None):
        raise AssertionError(msg)

    def _recv_internal(self, timeout):
        assert not self.asked, f"it goes on to wait, for {timeout:g} s"
        self.asked.append(timeout)
        self.back += 3600.0
        time.sleep(timeout)
        return None, False


def test_a_wall_clock_that_is_set_back_holds_nobody_who_listens(monkeypatch):
    bus = Silent()
    wall, monotonic = time.time, time.monotonic
    monkeypatch.setattr(time, "time", lambda: wall() - bus.back)
    monkeypatch.setattr(can.bus, "time", {wall: time.time, monotonic: monotonic}[can.bus.time])
    assert MessagePort(bus).receive(0.01) == b""
    assert bus.asked == [0.01]
