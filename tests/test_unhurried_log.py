"""A loop that tells a fault does not wait for whoever reads that."""

from __future__ import annotations

import fcntl
import logging
import os

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
