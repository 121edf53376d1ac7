"""``pa10d drives``: what drives remember, in words, whoever is asked for it."""

from __future__ import annotations

import contextlib
import json

import pytest

from backends.error_history import DriveErrors
from pa10d.cli import main

MEMORIES = [
    DriveErrors(0x05, 0x3210, (0x00073210, 0x4210)),
    DriveErrors(0, 0, ()),
    DriveErrors(0x20, None, None),
    DriveErrors(problem="no answer to SDO 0x1003:0"),
]


BESIDE = {"joint": 3, "was": 0.0, "reads": 0.5, "sentence": "joint 3 stood at 0 and reads 0.5 now"}


@pytest.fixture
def asked(monkeypatch):
    """What a daemon's client was asked for."""
    calls = []

    class Client:
        def wait_for_robot(self, *states):
            calls.append(states)
            return {"misplaced": [BESIDE]}

        def confirm(self):
            return {"misplaced": []}

        def drive_errors(self, *, clear=False):
            calls.append(clear)
            return [
                {"joint": k + 1, "name": f"J{k + 1}", **one.document()}
                for k, one in enumerate(MEMORIES)
            ]

    @contextlib.contextmanager
    def daemon_for(options):
        yield Client()

    monkeypatch.setattr("pa10d.cli.daemon_client.daemon_for", daemon_for)
    return calls


def test_errors_are_a_table_with_a_line_for_each(asked, capsys):
    assert main(["drives", "errors"]) == 1, "one of them did not answer"
    lines = [line.split("  ") for line in capsys.readouterr().out.splitlines()]
    cells = [[cell.strip() for cell in line if cell.strip()] for line in lines]
    assert cells == [
        ["joint", "error now", "remembered, newest first"],
        ["1 J1", "0x3210 (DC link overvoltage)",
         "0x3210 (DC link overvoltage), maker's own 0x0007"],
        ["0x4210 (device too hot)"],
        ["2 J2", "none", "none"],
        ["3 J3", "device profile", "keeps none"],
        ["4 J4", "?", "no answer to SDO 0x1003:0"],
    ]  # fmt: skip
    assert asked == [False]


def test_clear_says_what_is_left(asked, capsys):
    assert main(["drives", "clear", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [one["problem"] for one in found["drives"]] == [None] * 3 + [MEMORIES[3].problem]
    assert asked == [True]


def test_confirm_says_what_is_believed_now(asked, capsys):
    assert main(["drives", "confirm"]) == 0
    assert capsys.readouterr().out == f"{BESIDE['sentence']}: believed\n"
    assert asked == [("inactive",)]
