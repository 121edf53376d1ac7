"""An entry that a full disk did not take leaves nothing that would be set aside."""

from __future__ import annotations

import errno
import os

import pytest

from pa10d.store.folders import write_into


def test_a_folder_comes_with_its_first_file_or_not(tmp_path, monkeypatch):
    def full(_descriptor):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        write_into(tmp_path / "new", "state.json", "{}")
    assert list(tmp_path.iterdir()) == []


def test_what_was_there_stays(tmp_path, monkeypatch):
    write_into(tmp_path / "old", "state.json", "1")
    monkeypatch.setattr(os, "fsync", lambda _: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write_into(tmp_path / "old", "state.json", "2")
    assert [path.read_text() for path in (tmp_path / "old").iterdir()] == ["1"]
