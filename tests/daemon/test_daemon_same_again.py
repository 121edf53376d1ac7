"""Same seed, same plant, same plan: the same recording to the bit, however long anybody waited."""

from __future__ import annotations

import time

import numpy as np
import pytest

from pa10d.client import local_daemon
from pa10d.store import RunStore

pytestmark = [pytest.mark.alone, pytest.mark.timeout(240)]
PLAN = {"period": 4.0, "cycles": 1}


def recordings(folder, waits):
    """Two runs of one plan by a daemon of their own; values and times since the first sample."""
    with local_daemon(folder, clock="simulated") as arm:
        runs = []
        for seconds in waits:
            arm.enable()
            time.sleep(seconds)
            runs += arm.experiment("tracking", PLAN)["runs"]
            time.sleep(seconds)
            arm.disable()
        store = RunStore(folder)
        return [_values(store.read(run).samples) for run in runs]


def _values(samples):
    commands = samples.commands
    arrays = (
        samples.stamps - samples.stamps[0], samples.q, samples.tau, samples.temperature,
        commands.q, commands.dq, commands.tau,
    )  # fmt: skip
    return [np.ascontiguousarray(a).tobytes() for a in arrays]


@pytest.mark.long  # tests/bus shows the same without a daemon
def test_recordings_are_identical_to_the_bit(tmp_path):
    first, second = recordings(tmp_path / "a", waits=(0.0, 0.0))
    again, second_again = recordings(tmp_path / "b", waits=(0.7, 0.3))
    assert again == first
    assert second_again == second
    assert second[2] != first[2], "the noise goes on: two runs of one arm are not the same"
