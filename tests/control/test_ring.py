"""The ring: what readers in other processes see, also when they are overtaken."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from pa10d.control.record import RecordLayout
from pa10d.control.ring import Ring


def filled(ring: Ring, count: int) -> None:
    row = np.zeros(ring.layout.width)
    for k in range(count):
        row[1:] = k
        ring.append(row)


def test_rows_come_back_in_order():
    ring = Ring.create(2, 16, 0.002)
    filled(ring, 10)
    rows, lost = ring.read(3)
    assert lost == 0
    np.testing.assert_array_equal(rows[:, 0], np.arange(3, 10))
    np.testing.assert_array_equal(rows[:, 1], np.arange(3, 10))


def test_an_overtaken_reader_knows_how_much_it_lost():
    ring = Ring.create(2, 16, 0.002)
    filled(ring, 50)
    rows, lost = ring.read(3)
    np.testing.assert_array_equal(rows[:, 0], np.arange(34, 50))
    assert lost == 31


def test_a_row_that_is_being_rewritten_is_not_given_out():
    ring = Ring.create(2, 16, 0.002)
    filled(ring, 10)
    ring._rows[4, 0] = -1.0
    rows, lost = ring.read(0)
    assert 4.0 not in rows[:, 0]
    assert (len(rows), lost) == (9, 1)


def test_nothing_yet():
    ring = Ring.create(2, 16, 0.002)
    assert ring.last() is None
    assert ring.read(0)[0].shape == (0, RecordLayout(2).width)


def test_fields_have_their_places():
    layout = RecordLayout(3)
    row = np.arange(float(layout.width))
    assert layout.get(row, "time") == 1
    assert len(layout.get(row, "q")) == 3
    assert len(layout.get(np.stack([row, row]), "tau")) == 2
    taken = [layout.get(row, v) for v in layout.vectors]
    assert len(np.unique(np.concatenate(taken))) == 3 * len(layout.vectors)


def test_last_words_outlive_their_writer():
    ring = Ring.create(2, 16, 0.002)
    assert ring.said() is None
    ring.say({"kind": "drive_fault", "sentence": "joint 2: overcurrent"})
    assert ring.said()["sentence"] == "joint 2: overcurrent"
    ring.say(None)
    assert ring.said() is None


WRITER = """
import sys, numpy as np
from pathlib import Path
from pa10d.control.ring import Ring
ring = Ring.attach(Path(sys.argv[1]))
row = np.zeros(ring.layout.width)
for k in range(60000):
    row[1:] = k
    ring.append(row)
"""


def test_another_process_reads_whole_rows(tmp_path):
    ring = Ring.create(7, 256, 0.002, tmp_path / "ring")
    writer = subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path / "ring")])
    seen = lost = 0
    try:
        while ring.written < 60000 and writer.poll() is None:
            rows, missed = ring.read(seen + lost)
            assert np.all(rows[:, 1:] == rows[:, :1])  # no row mixes two cycles
            seen, lost = seen + len(rows), lost + missed
        rows, missed = ring.read(seen + lost)
    finally:
        writer.kill()
        writer.wait()
    assert seen + lost + len(rows) + missed == 60000
    assert seen > 0


def test_a_foreign_file_is_refused(tmp_path):
    (tmp_path / "ring").write_bytes(b"\0" * 10000)
    with pytest.raises(ValueError, match="not a ring"):
        Ring.attach(tmp_path / "ring")
