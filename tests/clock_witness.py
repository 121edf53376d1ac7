"""A process that does nothing but sleep, and knows by how much it overslept: what is tried in real
time is judged only where the machine kept it, before the test and while it ran."""

from __future__ import annotations

import subprocess
import sys
import time
from contextlib import closing

import pytest

LOOK = 2e-3  # s: one sleep
LOOKED_AT = 0.3  # s: how long the machine is measured before a test
TOO_LATE = 20e-3  # s: two periods of the loops that tests run in real time

_SLEEPER = f"""
import select, sys, time
worst, looked = 0.0, time.monotonic()
while True:
    asked = select.select([sys.stdin], [], [], {LOOK})[0]
    now = time.monotonic()
    worst, looked = max(worst, now - looked - {LOOK}), now  # no moment between two looks is missed
    if not asked:
        continue
    if not sys.stdin.readline():
        break
    print(worst, flush=True)
    worst = 0.0
"""


class ClockWitness:
    """While a test that needs real time runs, the machine is measured beside it."""

    def __init__(self) -> None:
        self._sleeper = subprocess.Popen(
            [sys.executable, "-S", "-c", _SLEEPER],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    @property
    def process(self) -> int:
        """Its number."""
        return self._sleeper.pid

    def worst(self) -> float:
        """The longest lateness [s] since it was asked last."""
        assert self._sleeper.stdin is not None
        assert self._sleeper.stdout is not None
        self._sleeper.stdin.write("\n")
        self._sleeper.stdin.flush()
        return float(self._sleeper.stdout.readline())

    def close(self) -> None:
        """Its end."""
        self._sleeper.communicate()


_WITNESS = pytest.StashKey[ClockWitness]()


@pytest.fixture(scope="session")
def _clock_witness():
    with closing(ClockWitness()) as witness:
        yield witness


@pytest.fixture(autouse=True)
def _time_is_kept(request):
    """What needs real time is not tried on a machine that does not keep it just now."""
    if request.node.get_closest_marker("realtime") is None:
        return
    witness = request.getfixturevalue("_clock_witness")
    witness.worst()
    time.sleep(LOOKED_AT)
    if (worst := witness.worst()) > TOO_LATE:
        pytest.skip(_late(worst))
    request.node.stash[_WITNESS] = witness


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Nor is a failure believed that such a machine may have caused: it is shown as skipped."""
    report = yield
    if report.when == "call" and _WITNESS in item.stash:
        worst = item.stash[_WITNESS].worst()
        if report.failed and worst > TOO_LATE:
            report.outcome = "skipped"
            report.longrepr = (*item.location[:2], f"Skipped: failed, but {_late(worst)}")
    return report


def _late(worst):
    return f"this machine came {worst * 1e3:.0f} ms late, {TOO_LATE * 1e3:.0f} may be"
