"""A loop that tells a fault does not wait for whoever reads that."""

from __future__ import annotations

import fcntl
import logging
import os
import subprocess
import sys

import pytest

from pa10d.common.unhurried_log import MOST, UnhurriedHandler


@pytest.fixture
def full():
    """A pipe that nobody reads: its two ends."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    fcntl.fcntl(writing, fcntl.F_SETPIPE_SZ, 4096)
    while True:
        try:
            os.write(writing, b"x" * 512)
        except BlockingIOError:
            break
    os.set_blocking(writing, True)
    yield reading, writing
    os.close(reading)


def record(text):
    return logging.LogRecord("control", logging.WARNING, "", 0, text, None, None)


@pytest.mark.timeout(20)
def test_a_pipe_that_nobody_reads_holds_nobody_up(full):
    reading, writing = full
    handler = UnhurriedHandler(writing)
    for k in range(MOST + 7):
        handler.emit(record(f"fault {k}"))
    handler.wait(0.01)
    said = b""
    while b"fault 999\n" not in said:
        said += os.read(reading, 1 << 16)
    handler.emit(record("the last one"))
    while not said.endswith(b"the last one\n") and b"the last one\n" not in said:
        said += os.read(reading, 1 << 16)
    told = said.decode().lstrip("x").splitlines()
    counts = [int(line.split()[1]) for line in told if line.startswith("… ")]
    assert [line for line in told if not line.startswith("… ")][:2] == ["fault 0", "fault 1"]
    assert counts in ([6], [7]), "one may have been on its way"


def test_what_cannot_be_put_into_words_ends_nothing():
    reading, writing = os.pipe()
    handler = UnhurriedHandler(writing)
    handler.emit(logging.LogRecord("x", logging.WARNING, "", 0, "%d", ("no number",), None))
    handler.emit(record("goes on"))
    assert os.read(reading, 1 << 12).decode().splitlines()[0] == "goes on"


def test_a_terminal_that_never_waits_is_waited_for(full):
    """Whoever shares it may have it so: the rest of a message was dropped."""
    reading, writing = full
    os.set_blocking(writing, False)
    handler = UnhurriedHandler(writing)
    handler.emit(record("is told all the same"))
    handler.wait(0.05)
    said = os.read(reading, 1 << 16)
    handler.emit(record("the last one"))
    while not said.endswith(b"one\n"):
        said += os.read(reading, 1 << 16)
    assert said.lstrip(b"x").decode().splitlines() == ["is told all the same", "the last one"]


LOGS = """
import logging, os
from pa10d.common.unhurried_log import log_unhurried
log_unhurried("worker: %(message)s")
"""

SHARES = (
    LOGS
    + """
from pa10d.common.parallel import shared_map
os.sched_getaffinity = lambda pid: {0, 1}

def say(number):
    logging.warning("said %d", number)
    return os.getpid()

print(len(set(shared_map(say, [0, 1, 2, 3]))))
"""
)


def carried_out(program, **how):
    command = [sys.executable, "-c", program]
    return subprocess.run(command, check=False, timeout=20, **how)


@pytest.mark.timeout(30)
def test_a_process_that_logs_so_still_shares_out_what_it_computes():
    """Its thread counted: every diagnosis by a daemon ran on one processor from then on."""
    ended = carried_out(SHARES, capture_output=True, text=True)
    assert ended.stdout == "2\n", "processes"
    told = sorted(ended.stderr.splitlines())
    assert told == [f"worker: said {k}" for k in range(4)], "and its child's are told, once"


@pytest.mark.timeout(30)
def test_what_a_process_dies_of_is_told_last(full):
    dies = LOGS + "logging.warning('first')\nraise ValueError('no number')"
    ended = carried_out(dies, capture_output=True, text=True)
    told = ended.stderr.splitlines()
    assert told[:2] == ["worker: first", "worker: ended by an error"]
    assert told[-1] == "ValueError: no number"
    assert ended.returncode == 1
    assert carried_out(dies, stderr=full[1]).returncode == 1, "nobody reads, and it ends"
