"""``pa10d robot``: the page's buttons at the command line, and a stop that needs no daemon."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time

import pytest

from pa10d.cli import main
from pa10d.client import ApiError
from pa10d.daemon.presence import LOCK, Presence, announced
from pa10d.daemon.processes.runtime import own
from pa10d.daemon.second_stop import stop_by_signal

ARM = {
    "profile": "two", "state": "inactive", "fault": None, "offline_reason": None, "outside": [],
    "misplaced": [], "unheld": [],
}  # fmt: skip
BRAKE = "disable: the brake of joint 2 does not hold its load; its motor holds it, and power stays"
OBEYS = (
    "import signal; signal.signal(signal.SIGUSR1, lambda *_: exit(7)); print(flush=True); "
    "signal.pause()"
)


class Daemon:
    """What was asked of it, and what it says."""

    def __init__(self):
        self.asked, self.says = [], ARM

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def let_others_command(self):
        self.asked.append("let go")

    def _said(self, *words):
        self.asked.append(words)
        if isinstance(self.says, BaseException):
            raise self.says
        return self.says

    def robot(self):
        return self._said("robot")

    def enable(self, recover):
        return self._said("enable", recover)

    def disable(self, anyway):
        return self._said("disable", anyway)

    def reset(self):
        return self._said("reset")


@pytest.fixture
def daemon(monkeypatch):
    found = Daemon()
    monkeypatch.setattr("pa10d.client.running_daemon", lambda _data: found)
    return found


@pytest.mark.parametrize(
    ("typed", "asked"),
    [
        ("state", ("robot",)), ("enable", ("enable", False)), ("enable --recover",
        ("enable", True)), ("disable", ("disable", False)), ("disable --anyway",
        ("disable", True)), ("reset", ("reset",)),
    ],
)  # fmt: skip
def test_it_asks_what_was_typed_and_gives_the_command_back(daemon, typed, asked):
    main(["robot", *typed.split()])
    assert daemon.asked == [asked, "let go"]


def test_a_brake_that_does_not_hold_is_told_and_no_success(daemon, capsys):
    daemon.says = ApiError({"detail": BRAKE, "status": 409})
    assert main(["robot", "disable"]) == 1
    assert BRAKE in capsys.readouterr().err
    assert daemon.asked[-1] == "let go"


def test_what_did_not_come_to_be_is_no_success(daemon, capsys):
    daemon.says = ARM | {"state": "fault", "fault": {"sentence": "joint 2: is too hot"}}
    assert main(["robot", "enable", "--json"]) == 1
    said = capsys.readouterr()
    assert json.loads(said.out)["state"] == "fault"
    assert said.err == "joint 2: is too hot\n"
    assert main(["robot", "state"]) == 0


@pytest.mark.parametrize("command", ["enable", "disable"])
def test_whoever_interrupts_is_told_that_the_daemon_goes_on(daemon, capsys, command):
    """ "interrupted" was said, and the arm got its power."""
    daemon.says = KeyboardInterrupt()
    assert main(["robot", command]) == 130
    said = capsys.readouterr().err
    assert said.startswith("interrupted: the daemon goes on")
    assert "'pa10d robot stop'" in said
    assert daemon.asked[-1] == "let go"


@pytest.fixture
def control():
    """A child of ours that looks like a control process."""
    words = [sys.executable, "-c", OBEYS, "-m", "pa10d.control"]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        yield process
        process.kill()


def test_a_daemon_that_does_not_answer_is_passed_over(tmp_path, control, capsys):
    with (
        own(tmp_path / LOCK, 0.0, "taken"),
        announced(tmp_path, Presence("http://127.0.0.1:9", os.getpid(), "two")),
    ):
        begun = time.monotonic()
        assert main(["--data", str(tmp_path), "robot", "stop"]) == 0
        assert time.monotonic() - begun < 5.0
    assert control.wait(10) == 7
    assert "control was told by a signal" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["state", "disable"])
def test_a_daemon_that_stands_still_is_no_daemon_that_is_not_there(
    tmp_path, monkeypatch, capsys, command
):
    """After a minute and a half it was said that none runs, of one whose arm has power."""
    monkeypatch.setattr("pa10d.client.daemons.SILENT", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"http://127.0.0.1:{silent.getsockname()[1]}"
        with (
            own(tmp_path / LOCK, 0.0, "taken"),
            announced(tmp_path, Presence(url, os.getpid(), "two")),
        ):
            assert main(["--data", str(tmp_path), "robot", command]) == 1
    said = capsys.readouterr().err
    assert f"the daemon on this data, process {os.getpid()}, does not answer" in said
    assert "'pa10d robot stop'" in said


def test_no_other_process_gets_the_signal(tmp_path, control, capsys):
    assert not stop_by_signal(control.pid), "its own parent is another"
    assert control.poll() is None
    words = [sys.executable, "-c", OBEYS, "pa10d.control"]
    control.kill()
    with subprocess.Popen(words, stdout=subprocess.PIPE) as other:
        other.stdout.readline()
        assert not stop_by_signal(os.getpid())
        with (
            own(tmp_path / LOCK, 0.0, "taken"),
            announced(tmp_path, Presence("http://127.0.0.1:9", os.getpid(), "two")),
        ):
            assert main(["--data", str(tmp_path), "robot", "stop"]) == 1
        assert "nor is there a control process" in capsys.readouterr().err
        other.kill()
