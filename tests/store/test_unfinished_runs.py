"""A writer that is killed loses at most what it had not flushed; the run is repaired."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader
from store_data import channels, samples

from pa10d.common.errors import UserError
from pa10d.services.library import open_library
from pa10d.services.models import read_runs
from pa10d.store import RunStore, run_writer
from pa10d.store.bag_repair import finish_bag
from pa10d.store.run_info import BAG
from pa10d.store.run_reader import read_run

WRITER = """
import sys, time
sys.path.insert(0, sys.argv[2])
from store_data import channels, samples
from pa10d.store import RunStore
writer = RunStore(sys.argv[1]).start("live", channels(commands=True))
start = 1_700_000_000_000_000_000
for k in range(100000):
    writer.append(samples(10, start_ns=start + k * 20_000_000, seed=k, commands=True))
    print(k, flush=True)
    time.sleep(0.02)
"""


def _killed_writer(data, after):
    here = os.path.dirname(__file__)
    with subprocess.Popen(
        [sys.executable, "-c", WRITER, str(data), here], stdout=subprocess.PIPE, text=True
    ) as process:
        for line in process.stdout:
            if int(line) >= after:
                break
        seen = _while_it_runs(data)
        process.send_signal(signal.SIGKILL)
        process.wait()
        last = [int(line) for line in process.stdout.read().split()]
    return seen, max([after, *last])


def _while_it_runs(data):
    """What another process sees: the run is there, is readable and not taken for dead."""
    store = RunStore(data)
    assert store.repaired == []
    info = store.find("live")
    assert info.status == "started"
    with pytest.raises(UserError, match="being recorded"):
        store.delete("live")
    return len(store.read("live").samples)


def test_a_killed_recorder_loses_a_fifth_of_a_second_at_most(tmp_path):
    seen, last = _killed_writer(tmp_path, after=40)
    assert seen >= 10
    store = RunStore(tmp_path)
    assert [info.name for info in store.repaired] == ["live"]
    info = store.find("live")
    assert (info.status, info.repaired) == ("failed", True)
    assert info.channels == ("commands",)
    assert "without closing" in info.reason
    run = store.read("live")
    assert run.complete
    assert info.samples == len(run.samples) >= seen
    lost = (last + 1) * 10 - len(run.samples)
    assert lost <= 0.2 / 0.02 * 10 + 40  # 0.2 s at the writer's pace, and what a busy machine adds
    again = samples(10, start_ns=1_700_000_000_000_000_000 + 3 * 20_000_000, seed=3, commands=True)
    np.testing.assert_array_equal(run.samples.q[30:40], again.q)
    with Reader(store.path(info)) as reader:
        assert reader.message_count == 2 * info.samples
        assert sum(1 for _ in reader.messages()) == 2 * info.samples
    assert RunStore(tmp_path).repaired == []


def test_a_run_that_is_being_recorded_is_fitted_and_judged_by_nobody(tmp_path):
    library = open_library(tmp_path)
    writer = library.runs.start("live", channels())
    writer.append(samples(300))
    writer.flush()
    with pytest.raises(UserError, match=r"'live': it is being recorded; expected a finished run"):
        read_runs(library, ["live"], None, force=True)
    writer.close()
    assert len(read_runs(library, ["live"], None, force=True)[1]) == 1


@pytest.fixture
def finished(tmp_path):
    store = RunStore(tmp_path)
    writer = store.start("run", channels(dq=True))
    for k in range(4):
        writer.append(samples(50, start_ns=10**18 + k * 10**8, seed=k, dq=True))
        writer.flush()
    info = writer.close()
    return store.path(info) / BAG, store


def test_any_cut_is_repaired_and_keeps_every_whole_chunk(finished):
    """Cut at many places, also within chunks and indexes: readable by us before the repair and by
    the mcap library after it, with all chunks that were whole."""
    bag, _ = finished
    whole = bag.read_bytes()
    ends = _chunk_ends(whole)
    rng = np.random.default_rng(0)
    places = {*rng.integers(ends[0], len(whole), 60).tolist(), *ends, ends[-1] + 1, len(whole) - 1}
    for cut in sorted(places):
        bag.write_bytes(whole[:cut])
        kept = 50 * sum(end <= cut for end in ends)
        assert len(read_run(bag).samples) == kept
        finish_bag(bag)
        assert len(read_run(bag).samples) == kept
        with bag.open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            assert reader.get_summary().statistics.message_count == kept
            assert sum(1 for _ in reader.iter_messages()) == kept


def _chunk_ends(data):
    ends, at = [], 8
    while at + 9 <= len(data) - 8:
        opcode, length = data[at], int.from_bytes(data[at + 1 : at + 9], "little")
        at += 9 + length
        if opcode == 6:
            ends.append(at)
    return ends


def test_a_flipped_bit_in_the_last_chunk_of_an_unfinished_file_drops_that_chunk(finished):
    bag, _ = finished
    data = bytearray(bag.read_bytes())
    end = _chunk_ends(data)[-1]
    data[end - 5] ^= 1
    bag.write_bytes(data[:end])
    finish_bag(bag)
    assert len(read_run(bag).samples) == 150


def test_a_finished_file_is_left_alone(finished):
    bag, _ = finished
    before = bag.read_bytes()
    assert finish_bag(bag).finished_before
    assert bag.read_bytes() == before


def test_a_crash_between_bag_and_description_keeps_the_ending(finished):
    """The bag says how the run ended; the description had not been written."""
    bag, store = finished
    info = store.find("run")
    info.but(status="started").save(bag.parent)
    (repaired,) = RunStore(store.folder.parent).repaired
    assert (repaired.status, repaired.samples) == ("success", 200)


def test_a_run_without_a_sample_is_marked_and_says_so(tmp_path):
    store = RunStore(tmp_path)
    store.start("empty", channels()).abandon()
    (info,) = RunStore(tmp_path).repaired
    assert info.status == "failed"
    with pytest.raises(UserError, match="no measurement"):
        store.read("empty")


def test_something_else_than_a_bag(tmp_path):
    path = tmp_path / "x.mcap"
    path.write_bytes(b"not a bag at all")
    with pytest.raises(UserError, match="not an MCAP file"):
        finish_bag(path)


def test_appended_samples_are_on_disk_after_a_fifth_of_a_second(tmp_path, monkeypatch):
    clock = SimpleNamespace(now=100.0)
    monkeypatch.setattr(run_writer, "time", SimpleNamespace(monotonic=lambda: clock.now))
    store = RunStore(tmp_path)
    writer = store.start("live", channels())
    on_disk = []
    for k, waited in enumerate((0.21, 0.19, 0.02, 0.19, 0.02)):
        clock.now += waited
        writer.append(samples(1, start_ns=10**18 + k * 2_000_000, seed=k))
        on_disk.append(len(store.read("live").samples))
    assert on_disk == [1, 1, 3, 3, 5]
    writer.append(samples(1, start_ns=2 * 10**18))
    writer.close()
    assert len(store.read("live").samples) == 6
