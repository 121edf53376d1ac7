"""A disk that fills up: said before, survived during, and the reason kept after."""

from __future__ import annotations

import io
import subprocess

import numpy as np
import pytest
from mcap.reader import make_reader
from store_data import channels, samples

from pa10d.common.errors import UserError
from pa10d.control.record import RecordLayout
from pa10d.recorder.session import Session
from pa10d.services.prepared_motion import room_check
from pa10d.store import RunStore, room, run_writer
from pa10d.store.run_info import BAG

FULL = OSError(28, "No space left on device")


class FullAfter(io.FileIO):
    """A disk with room for so many bytes."""

    most = 60_000

    def write(self, data):
        if self.tell() + len(data) > self.most:
            super().write(data[: max(0, self.most - self.tell())])
            raise FULL
        return super().write(data)


@pytest.fixture
def small_disk(monkeypatch):
    def opened(path):
        return io.BufferedWriter(FullAfter(path, "w"), 1 << 16)

    monkeypatch.setattr(run_writer, "_open", opened)


def test_a_run_that_finds_no_room_does_not_begin(tmp_path, monkeypatch):
    store = RunStore(tmp_path)
    needed = room.size_of_run(channels(commands=True), 1_000_000)
    assert 3e8 < needed < 4e8
    monkeypatch.setattr(room, "free", lambda folder: needed + room.SPARE - 1)
    with pytest.raises(UserError, match=r"are free, the run needs \d+ MB"):
        store.start("x", channels(commands=True), samples=1_000_000)
    assert store.all() == []
    assert list(store.folder.glob(".new-*")) == []
    store.start("x", channels(commands=True), samples=900_000).abandon()
    check = room_check(tmp_path, 10 * needed)
    assert (check.level, check.subject) == ("error", "disk")
    assert room_check(tmp_path, 1).level == "ok"


def test_the_size_that_is_foreseen_is_the_size_that_is_written(tmp_path):
    store = RunStore(tmp_path)
    have = {"commands": True, "temperature": True}
    writer = store.start("x", channels(**have))
    writer.append(samples(5000, **have))
    info = writer.close()
    size = (store.path(info) / BAG).stat().st_size
    assert size <= room.size_of_run(channels(**have), 5000) <= 1.05 * size + room.RESERVE


@pytest.mark.usefixtures("small_disk")
def test_a_disk_that_fills_up_ends_the_run_and_keeps_what_was_written(tmp_path):
    store = RunStore(tmp_path)
    old = store.start("live", channels())
    old.append(samples(10))
    old.close()
    writer = store.start("live", channels(), replace=True)
    taken = 0
    with pytest.raises(OSError, match="No space"):  # noqa: PT012
        for k in range(100):
            writer.append(samples(50, start_ns=10**18 + k * 10**8, seed=k))
            writer.flush()
            taken += 50
    info = Session(writer, RecordLayout(3), 1, 10_000).salvage(FULL)
    assert (info.status, info.repaired, info.samples) == ("failed", False, taken)
    assert "No space left on device while recording" in info.reason
    again = RunStore(tmp_path)
    assert again.repaired == []
    assert again.find(info.id) == info
    assert again.find("live").id == old.info.id
    np.testing.assert_array_equal(again.read(info.id).samples.q[:50], samples(50, seed=0).q)
    with (store.path(info) / BAG).open("rb") as file:
        assert make_reader(file, validate_crcs=True).get_summary().statistics.message_count == taken
    assert not (store.path(info) / room.FILE).exists()


@pytest.fixture
def mounted(tmp_path):
    """A real file system of 40 MB."""
    place = tmp_path / "small"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=40m", "none", str(place)]
    try:
        done = subprocess.run(mount, capture_output=True, check=False).returncode == 0
    except OSError:
        done = False
    if not done:
        pytest.skip("needs the right to mount a file system")
    yield place
    subprocess.run(["umount", str(place)], check=True)


def test_a_real_disk_that_fills_up(mounted):
    store = RunStore(mounted)
    writer = store.start("live", channels(commands=True))
    with pytest.raises(OSError, match="No space"):  # noqa: PT012
        for k in range(10_000):
            writer.append(samples(500, start_ns=10**18 + k * 10**9, seed=k, commands=True))
            writer.flush()
    info = Session(writer, RecordLayout(3), 1, 10_000_000).salvage(FULL)
    assert info.samples > 10_000
    assert len(RunStore(mounted).read("live").samples) == info.samples
    assert "No space" in RunStore(mounted).find("live").reason
