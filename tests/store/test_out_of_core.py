"""Recordings that are too large for memory are read a stretch at a time, with the same result."""

from __future__ import annotations

import gc
import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from subprocess import run as start

import numpy as np
import pytest

from pa10d.identify import FitOptions
from pa10d.judgement.judge import no_more_than
from pa10d.measurement.recording import Recording
from pa10d.services import models
from pa10d.services.library import open_library
from pa10d.services.robots import load_robot
from pa10d.store import Channels, Samples
from pa10d.store.out_of_core import RecordingOnDisk

T = np.arange(4000) / 200.0
SCRIPTS = Path(__file__).parents[2] / "scripts"


@pytest.fixture
def recording():
    q = 0.5 * np.sin(T[:, None] * [1.0, 1.7])
    dq = 0.5 * np.cos(T[:, None] * [1.0, 1.7]) * [1.0, 1.7]
    return Recording("r", T, q, 3 * q + dq, dq, excluded=((2.0, 3.0), (15.0, 16.0)))


def test_it_says_the_same_as_in_memory(recording, tmp_path):
    stored = RecordingOnDisk(recording, tmp_path)
    assert isinstance(stored, Recording)
    for name in ("t", "q", "tau", "dq"):
        assert np.array_equal(getattr(stored, name), getattr(recording, name))
    assert stored.temperature is None
    assert (stored.joints, stored.rate, stored.duration) == (2, recording.rate, recording.duration)
    assert np.array_equal(stored.left_out, recording.left_out)
    one, other = stored.part(500, 3100, "-a"), recording.part(500, 3100, "-a")
    assert type(one) is Recording
    assert (one.name, one.excluded) == (other.name, other.excluded)
    assert np.array_equal(one.tau, other.tau)
    assert stored.part(3990, 9999, "").t.shape == (10,)


def test_its_file_has_no_name_and_goes_with_it(recording, tmp_path):
    before = len(os.listdir("/proc/self/fd"))
    stored = RecordingOnDisk(recording, tmp_path)
    assert list(tmp_path.iterdir()) == []
    assert len(os.listdir("/proc/self/fd")) == before + 1
    del stored
    gc.collect()
    assert len(os.listdir("/proc/self/fd")) == before


def test_a_model_of_runs_on_disk_is_the_same(tmp_path, monkeypatch):
    profile, robot = load_robot("ur5e")
    library = open_library(tmp_path)
    rng = np.random.default_rng(1)
    w, phase = rng.uniform(0.5, 3.0, robot.n), rng.uniform(0, 6, robot.n)
    q = 0.6 * np.sin(T[:, None] * w + phase) + 0.2 * np.sin(2.7 * T[:, None] * w)
    tau = 5 * q + 2 * np.gradient(q, T, axis=0) + 0.1 * rng.normal(size=q.shape)
    channels = Channels(joints=robot.joint_names)
    for name, cut in (("a", slice(0, 2400)), ("b", slice(1600, 4000))):
        with library.runs.building(name, name, channels, profile) as writer:
            stamps = np.rint(T[: len(q[cut])] * 1e9).astype(np.int64)
            writer.append(Samples(stamps, q[cut], tau[cut]))
    opened = []
    made = RecordingOnDisk.__init__
    monkeypatch.setattr(
        RecordingOnDisk, "__init__", lambda self, *a: opened.append(a) or made(self, *a)
    )
    found = []
    for largest in (1e9, 0):
        monkeypatch.setattr(models, "LARGE", largest)
        name = f"m{len(found)}"
        found.append(
            models.identify_runs(
                library, ["a", "b"], str(profile.path), name=name, options=FitOptions(8.0)
            )
        )
    assert len(opened) == 2
    one, other = (f.model for f in found)
    assert np.array_equal(one.h, other.h)
    assert np.array_equal(one.covariance, other.covariance)
    assert np.array_equal(one.noise, other.noise)


def test_of_very_long_runs_the_middle_is_judged_and_short_ones_stay_whole(recording):
    short = replace(recording.part(0, 1000, ""), name="s", excluded=())
    assert no_more_than(5000, [recording, short])[0] is recording
    kept = no_more_than(3500, [recording, short])
    assert [len(one.t) for one in kept] == [2500, 1000]
    assert kept[1] is short
    assert float(kept[0].t[0]) == T[750]
    assert [len(one.t) for one in no_more_than(1500, [recording, short])] == [750, 750]


@pytest.mark.long
def test_memory_does_not_grow_with_the_number_of_runs():
    peaks = {}
    for runs in (3, 6):
        words = [str(SCRIPTS / "bench.py"), "long", "--json", "--bag", "0", "--minutes", "15"]
        call = [sys.executable, *words, "--runs", str(runs)]
        done = start(call, capture_output=True, text=True, check=True)
        peaks[runs] = json.loads(done.stdout)["identify"]["peak"]
    print(peaks)
    assert peaks[6] < 2e9
    assert peaks[6] < 1.2 * peaks[3]
