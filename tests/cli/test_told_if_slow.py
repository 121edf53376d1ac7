"""Whoever waits at a terminal is told why; whoever need not wait reads nothing."""

from __future__ import annotations

import sys

import pytest

from pa10d.cli import progress


class Waiting:
    """A timer whose time comes when the test says so."""

    def __init__(self, seconds, call, arguments):
        self.seconds, self.call, self.arguments = seconds, call, arguments
        self.started = self.cancelled = False
        made.append(self)

    def start(self):
        self.started = True

    def cancel(self):
        self.cancelled = True

    def time_comes(self):
        if self.started and not self.cancelled:
            self.call(*self.arguments)


made: list[Waiting] = []


@pytest.fixture(autouse=True)
def timers(monkeypatch):
    made.clear()
    monkeypatch.setattr(progress.threading, "Timer", Waiting)


@pytest.mark.parametrize(
    ("terminal", "in_time", "told"),
    [(True, False, True), (True, True, False), (False, False, False)],
)
def test_who_is_told(monkeypatch, capsys, terminal, in_time, told):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal, raising=False)
    done = progress.told_if_slow("it compiles")
    assert capsys.readouterr().err == "", "nobody wonders yet"
    if in_time:
        done()
    for timer in made:
        timer.time_comes()
    assert ("it compiles" in capsys.readouterr().err) == told
