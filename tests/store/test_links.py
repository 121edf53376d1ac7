"""Links and pipes among stored things: nothing outside the data folder is written or removed."""

from __future__ import annotations

import json
import os
import shutil

import pytest
from store_data import channels, samples

from pa10d.common.errors import UserError
from pa10d.investigation.archive import Archive
from pa10d.investigation.results import Way
from pa10d.services.tuning.versions import versions_in
from pa10d.services.weighing.archive import Weighings
from pa10d.store import RunStore
from pa10d.store.bag_repair import CUT
from pa10d.store.entries import is_own_file, own_folder
from pa10d.store.folders import write_text
from pa10d.store.models import ModelStore
from pa10d.store.run_info import BAG

PRECIOUS = "precious" * 10


@pytest.fixture
def victim(tmp_path):
    path = tmp_path / "victim"
    path.write_text(PRECIOUS)
    return path


@pytest.fixture
def torn(tmp_path):
    """A store, closed, and in it the folder of a run whose recorder was killed in a chunk."""
    store = RunStore(tmp_path / "data")
    writer = store.start("live", channels())
    writer.append(samples(50))
    writer.flush()
    writer.abandon()
    folder = store.path(writer.info)
    with (folder / BAG).open("ab") as file:
        file.write(b"torn off")
    return folder


@pytest.mark.parametrize("opened", [RunStore, ModelStore, Archive, Weighings])
def test_a_link_whose_disk_is_gone_is_told(tmp_path, opened):
    """It was said that the file exists."""
    folder = opened(tmp_path / "data").folder
    folder.rmdir() if folder.name != "runs" else shutil.rmtree(folder)
    folder.symlink_to(tmp_path / "larger disk")
    with pytest.raises(UserError, match=f"/{folder.name}: found a link to .*/larger disk, which"):
        opened(tmp_path / "data")
    (tmp_path / "larger disk").mkdir()
    assert opened(tmp_path / "data").all() == []


def test_so_is_a_file_in_the_place_of_a_folder(tmp_path):
    (tmp_path / "runs").touch()
    with pytest.raises(UserError, match="/runs: found a file; expected a folder for runs, or a li"):
        RunStore(tmp_path)
    with pytest.raises(UserError, match="/runs: found a file; expected a folder for runs and mode"):
        RunStore(tmp_path / "runs")


def _reopened(folder):
    return RunStore(folder.parents[1])


@pytest.mark.parametrize("name", [f"run{CUT}", ".run.json.{pid}"])
def test_a_repair_does_not_write_through_a_link(torn, victim, name):
    (torn / name.format(pid=os.getpid())).symlink_to(victim)
    (info,) = _reopened(torn).repaired
    assert info.repaired
    assert victim.read_text() == PRECIOUS
    assert (torn / f"run{CUT}").read_bytes() == b"torn off"


def test_a_repair_does_not_write_into_a_pipe(torn):
    pipe = torn / f"run{CUT}"
    os.mkfifo(pipe)
    heard = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)  # else opening it to write never ends
    try:
        _reopened(torn)
        assert os.read(heard, 100) == b""
    finally:
        os.close(heard)
    assert pipe.read_bytes() == b"torn off"


def test_a_link_to_itself_among_new_runs(torn):
    os.symlink(".new-run", torn.parent / ".new-run")
    assert [info.name for info in _reopened(torn).all()] == ["live"]


@pytest.mark.parametrize("kind", [RunStore, ModelStore, Archive, Weighings])
def test_a_name_that_is_no_text_is_told_all_the_same(tmp_path, kind):
    store = kind(tmp_path)
    (store.folder / os.fsdecode(b"of \xff.yaml")).mkdir()
    (other,) = kind(tmp_path).set_aside()
    said = json.dumps(other.document(), ensure_ascii=False).encode().decode()
    assert r"of \\udcff" in said
    with pytest.raises(UserError) as refusal:
        store.find(other.id)
    assert str(refusal.value).encode()


def test_a_folder_that_is_a_link_is_not_taken_for_ones_own(tmp_path, victim):
    os.symlink(tmp_path, tmp_path / "link")
    with pytest.raises(UserError, match="a link"):
        own_folder(tmp_path / "link")
    with pytest.raises(UserError, match="no folder"):
        own_folder(victim)
    assert own_folder(own_folder(tmp_path / "new")) == tmp_path / "new"


def test_a_file_behind_a_link_is_not_shown(tmp_path, victim):
    os.symlink(tmp_path, tmp_path / "link")
    os.symlink(victim, tmp_path / "named")
    assert is_own_file(victim)
    assert not is_own_file(tmp_path / "named")
    assert not is_own_file(tmp_path / "link" / "victim")


def test_a_draft_that_was_left_behind_is_replaced(tmp_path):
    (tmp_path / f".kept.{os.getpid()}").write_text("of a process of the same number, killed")
    write_text(tmp_path / "kept", "new")
    assert [file.name for file in tmp_path.iterdir()] == ["kept"]
    assert (tmp_path / "kept").read_text() == "new"


@pytest.mark.parametrize("name", ["../../../victim", "/etc/hostname", "a/b", ".."])
def test_what_settles_a_doubt_is_called_by_a_plain_name(tmp_path, name):
    from pa10d.common.jsonable import parsed

    way = {"seconds": 1.0, "says": "", "problem": "", "plan": "1-friction.yaml", "motion": None}
    assert parsed(Way, way)
    for key in ("plan", "motion"):
        with pytest.raises(ValueError, match="pattern"):
            parsed(Way, way | {key: name})


def test_versions_of_a_profile_that_nest_too_deep(tmp_path):
    (tmp_path / "0001.json").write_text("[" * 100_000)
    os.mkfifo(tmp_path / "0002.json")
    first, second = versions_in(tmp_path, tmp_path / "arm.yaml")
    assert first.damaged
    assert second.damaged
    assert second.changes == [
        f"cannot be read: {tmp_path / '0002.json'}: found no file, expected a file of its own"
    ]
