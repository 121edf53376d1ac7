"""Whoever waits at a terminal is told why; whoever need not wait reads nothing."""

from __future__ import annotations

import sys
import time

import pytest

from pa10d.cli import progress


@pytest.fixture(autouse=True)
def short(monkeypatch):
    monkeypatch.setattr(progress, "QUIET", 0.05)


def waited(capsys, words: str, seconds: float = 10.0) -> str:
    until, said = time.monotonic() + seconds, ""
    while words not in said and time.monotonic() < until:
        time.sleep(0.01)
        said += capsys.readouterr().err
    return said


def test_a_slow_start_is_told_at_a_terminal(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    progress.told_if_slow("it compiles")
    assert "it compiles" in waited(capsys, "it compiles")


@pytest.mark.parametrize(("terminal", "in_time"), [(True, True), (False, False)])
def test_nobody_else_reads_it(monkeypatch, capsys, terminal, in_time):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal, raising=False)
    done = progress.told_if_slow("it compiles")
    if in_time:
        done()
    assert waited(capsys, "it compiles", 0.3) == ""
