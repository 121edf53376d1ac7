"""A machine that stood still is told from a program that is wrong."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from contextlib import closing
from pathlib import Path

import pytest
from clock_witness import ClockWitness


def test_a_witness_that_is_asked_while_it_stands_still_says_so():
    """It answered the question first, and forgot that it had just overslept."""
    with closing(ClockWitness()) as witness:
        witness.worst()
        os.kill(witness.process, signal.SIGSTOP)
        wakes = threading.Timer(0.2, os.kill, [witness.process, signal.SIGCONT])
        wakes.start()
        assert witness.worst() > 0.1
        wakes.join()


TRIED = """
import os, signal, time
import clock_witness, pytest

@pytest.mark.realtime
def test_it(_clock_witness):
    if {stands_still}:
        os.kill(_clock_witness.process, signal.SIGSTOP)
        time.sleep(0.3)
        os.kill(_clock_witness.process, signal.SIGCONT)
        time.sleep(0.05)
    else:
        clock_witness.TOO_LATE = 10.0
    assert {holds}
"""


@pytest.mark.parametrize(
    ("stands_still", "holds", "outcome"),
    [(True, False, "1 skipped"), (True, True, "1 passed"), (False, False, "1 failed")],
)
def test_a_failure_is_believed_where_time_was_kept(stands_still, holds, outcome, tmp_path):
    (tmp_path / "test_it.py").write_text(TRIED.format(stands_still=stands_still, holds=holds))
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = realtime\n")
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "clock_witness", "-rs", str(tmp_path)],
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parent)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    if "skipped" in ran.stdout and "failed, but" not in ran.stdout:
        pytest.skip("this machine did not keep time before the trial")
    assert outcome in ran.stdout
