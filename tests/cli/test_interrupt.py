"""Ctrl-C ends a command whatever it is in the middle of: status 130, no process left behind."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time

import pytest

from pa10d.store import RunStore
from pa10d.store.folders import NEW, locked

STUCK = """
import multiprocessing, sys, time
import pa10d.cli.process as process

def main():
    child = multiprocessing.get_context("fork").Process(target=time.sleep, args=(60,))
    child.start()
    print(child.pid, flush=True)
    while True:  # as deep in a library, where nobody notices
        try:
            time.sleep(60)
        except KeyboardInterrupt:
            pass

process.main = main
process.run()
"""
PATIENT = """
import pa10d.cli.process as process

process.GRACE = 60.0  # s: it is to end by itself, however slow the machine
process.run()
"""
SOON = 30.0  # s: what is asked for is one, which a busy machine may stretch


def test_a_command_that_does_not_notice_is_ended_with_its_children():
    with subprocess.Popen([sys.executable, "-c", STUCK], stdout=subprocess.PIPE) as process:
        child = int(process.stdout.readline())
        process.send_signal(signal.SIGINT)
        assert process.wait(SOON) == 130
    with pytest.raises(ProcessLookupError):
        _wait_for_end(child)


def test_an_import_interrupted_at_its_file_leaves_nothing(tmp_path):
    """It waits for the first line, which never comes."""
    log = tmp_path / "log.csv"
    os.mkfifo(log)
    with importing(log) as process:
        end = _written_to(log, process)
        process.send_signal(signal.SIGINT)
        _ended_with_nothing_left(process, RunStore(tmp_path / "data"))
        os.close(end)


def test_an_import_interrupted_while_it_writes_leaves_nothing(tmp_path):
    """Somebody else has the store, so that the run stays half-written until it is interrupted."""
    log = tmp_path / "log.csv"
    names = ",".join([f"q{j}" for j in range(1, 8)] + [f"tau{j}" for j in range(1, 8)])
    rows = "\n".join(f"{k / 500}," + ",".join(["0.1"] * 14) for k in range(400))
    log.write_text(f"time,{names}\n{rows}\n")
    store = RunStore(tmp_path / "data")
    with locked(store.folder), importing(log) as process:
        while not list(store.folder.glob(f"{NEW}*/*.mcap")):
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _ended_with_nothing_left(process, store)


def importing(log):
    """An import into the folder ``data`` beside the file."""
    words = ["--data", str(log.parent / "data"), "run", "import", str(log), "--profile", "pa10-sim"]
    return subprocess.Popen(
        [sys.executable, "-c", PATIENT, *words], stderr=subprocess.PIPE, text=True
    )


def _written_to(pipe, process):
    """The end to write to, once the process reads at the other; nothing is ever written there."""
    while True:
        assert process.poll() is None
        with contextlib.suppress(OSError):
            return os.open(pipe, os.O_WRONLY | os.O_NONBLOCK)
        time.sleep(0.01)


def _ended_with_nothing_left(process, store):
    said = process.communicate(timeout=SOON)[1]
    assert process.returncode == 130
    assert said.strip() in ("", "interrupted")
    assert store.all() == []
    assert list(store.folder.glob(f"{NEW}*")) == []


def _wait_for_end(pid):
    until = time.monotonic() + SOON
    while time.monotonic() < until:
        os.kill(pid, 0)
        time.sleep(0.05)
