"""Names, ids, replacing, deleting: nothing is lost, nothing half-written is seen."""

from __future__ import annotations

import os
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from store_data import channels, samples

from pa10d.common.errors import UserError
from pa10d.store import RunStore
from pa10d.store.folders import locked
from pa10d.store.location import data_place
from pa10d.store.names import checked_name, free_name, new_id, resolve
from pa10d.store.run_info import FILE, RunInfo


@pytest.fixture
def store(tmp_path):
    return RunStore(tmp_path)


def _build(store, name=None, stem="file", seed=0, **more):
    with store.building(name, stem, channels(), **more) as writer:
        writer.append(samples(120, seed=seed))
    return writer.info


def test_ids_sort_by_time_and_differ():
    ids = [new_id() for _ in range(50)]
    assert len(set(ids)) == 50
    assert [i[:18] for i in ids] == sorted(i[:18] for i in ids)


def test_an_id_comes_before_a_name_and_a_name_before_the_start_of_an_id():
    def run(run_id, name):
        return RunInfo(run_id, name, "", "", ())

    runs = [run("1-a", "one"), run("1-ab", "1-a"), run("2-x", "2"), run("3-y", "three")]
    assert resolve("1-a", runs, "run").id == "1-a", "another's name does not stand before an id"
    assert resolve("1-ab", runs, "run").id == "1-ab"
    assert resolve("2", runs, "run").id == "2-x"
    assert resolve("3", runs, "run").name == "three"
    with pytest.raises(UserError, match="'1': 2 ids begin so: 1-a"):
        resolve("1", runs, "run")
    for nothing in ("", "x", "thr"):
        with pytest.raises(UserError, match="none of this name or id"):
            resolve(nothing, runs, "run")


@pytest.mark.parametrize(
    "name",
    ["", " a", "a/b", "a\\b", "a\nb", ".a", "-a", "x" * 101, "\x7f", "a\x9b31m", "a\u2028b",
     "a\udcff", "a\uffff"],
)  # fmt: skip
def test_names_that_cannot_be(name):
    with pytest.raises(UserError, match="expected"):
        checked_name(name)


@pytest.mark.parametrize("name", ["a", "Lauf 7 ä", "2026-01-31", "a.b-c_d", "x" * 100])
def test_names_that_can(name, store):
    assert _build(store, checked_name(name)).name == name
    assert store.find(name).samples == 120


def test_a_free_name_is_numbered():
    assert free_name("a", {"b"}) == "a"
    assert free_name("a", {"a", "a-2"}) == "a-3"


def test_a_taken_name_is_refused_and_the_old_run_stays(store):
    old = _build(store, "one", seed=1)
    with pytest.raises(UserError, match=r"run 'one': there is one already.*--replace"):
        _build(store, "one", seed=2)
    with pytest.raises(UserError, match="there is one already"):
        store.start("one", channels())
    assert [info.id for info in store.all()] == [old.id]
    np.testing.assert_array_equal(store.read("one").samples.q, samples(120, seed=1).q)


def test_a_replaced_run_is_gone_and_the_new_one_there(store):
    old = _build(store, "one", seed=1)
    new = _build(store, "one", seed=2, replace=True)
    assert [info.id for info in store.all()] == [new.id]
    assert not (store.folder / old.id).exists()
    np.testing.assert_array_equal(store.read("one").samples.q, samples(120, seed=2).q)


def test_without_a_name_the_file_s_is_numbered(store):
    names = [_build(store, stem="train").name for _ in range(3)]
    assert names == ["train", "train-2", "train-3"]


def test_a_failure_while_writing_leaves_nothing_and_the_old_run(store):
    _build(store, "one", seed=1)

    def fail():
        with store.building("one", "f", channels(), replace=True) as writer:
            writer.append(samples(50))
            raise ValueError("in the middle")

    with pytest.raises(ValueError, match="in the middle"):
        fail()
    assert len(store.all()) == 1
    np.testing.assert_array_equal(store.read("one").samples.q, samples(120, seed=1).q)
    assert {p.name for p in store.folder.iterdir()} == {".lock", store.find("one").id}


def test_a_full_disk_is_one_line_and_leaves_nothing(store, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pa10d.store.run_writer.os.fsync", full)
    with pytest.raises(UserError, match=r"No space left .* not stored; expected room"):
        _build(store, "one")
    assert store.all() == []
    assert {p.name for p in store.folder.iterdir()} <= {".lock"}


def test_a_crash_between_new_and_old_keeps_both(store):
    """The new run had taken the name when the power went: it keeps it, and the old one is told
    apart, for by its name nobody could mean it any more."""
    old = _build(store, "one", seed=1)
    new = _build(store, "two", seed=2)
    new.but(name="one").save(store.path(new))
    again = RunStore(store.folder.parent)
    assert [(info.id, info.name) for info in again.all()] == [(old.id, "one-2"), (new.id, "one")]
    (said,) = again.find("one-2").warnings
    assert said == "was called 'one' until a newer run had that name"
    np.testing.assert_array_equal(again.read("one-2").samples.q, samples(120, seed=1).q)
    writer = again.start("one", channels(), replace=True)
    writer.append(samples())
    third = writer.close()
    assert third.name == "one", "each later one was called one-2: another had taken the name"
    assert [info.id for info in again.all()] == [old.id, third.id]


def test_a_run_that_is_being_recorded_keeps_its_name(store):
    """Its writer would write it back."""
    writer = store.start("one", channels())
    new = _build(store, "two")
    new.but(name="one").save(store.path(new))
    names = [info.name for info in RunStore(store.folder.parent).all()]
    writer.close()
    assert names == ["one", "one"]


def test_what_a_killed_import_left_is_swept_once_it_is_old(store):
    """Nothing else that is called so: the folder may be a link to where somebody keeps more."""
    names = (".new-20260101-120000000-aaaaaa", ".new-20260101-120000000-bbbbbb",
             ".trash-20260101-120000000-cccccc-1767268800000000000")  # fmt: skip
    young, old, trash = (store.folder / name for name in names)
    others = [store.folder / name for name in (".new-ideas", ".trash-of-mine")]
    for folder in (young, old, trash, *others):
        folder.mkdir()
        (folder / "run.mcap").write_bytes(b"half")
    past = time.time() - 3600
    for folder in (old, *others):
        os.utime(folder, (past, past))
    RunStore(store.folder.parent)
    assert all((folder / "run.mcap").exists() for folder in (young, *others))
    assert not old.exists()
    assert not trash.exists()


def test_deleting(store):
    info = _build(store, "one")
    assert store.delete("one").id == info.id
    assert store.all() == []
    with pytest.raises(UserError, match="none of this name"):
        store.delete("one")


def test_renaming_and_tagging(store):
    _build(store, "one")
    _build(store, "two")
    assert store.change("one", name="first", tags=("warm", "loaded")).tags == ("warm", "loaded")
    assert store.find("first").tags == ("warm", "loaded")
    with pytest.raises(UserError, match="there is one already"):
        store.change("first", name="two")


def test_two_that_want_one_name_at_the_same_time(store):
    """Exactly one gets it; the other is refused; unnamed ones are all numbered."""
    outcomes = []

    def build(name):
        try:
            outcomes.append(_build(RunStore(store.folder.parent), name, stem="s").name)
        except UserError as error:
            outcomes.append(str(error)[:11])

    for names in (["x"] * 4, [None] * 4):
        threads = [threading.Thread(target=build, args=(name,)) for name in names]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert sorted(outcomes[:4]) == ["run 'x': th"] * 3 + ["x"]
    assert sorted(outcomes[4:]) == ["s", "s-2", "s-3", "s-4"]


def test_a_folder_that_is_no_run_is_passed_over(store):
    _build(store, "one")
    (store.folder / "stray").mkdir()
    broken = store.folder / "broken"
    broken.mkdir()
    (broken / "run.json").write_text("{")
    assert [info.name for info in store.all()] == ["one"]


def _dated(store, created):
    """The same data folder after somebody has written another time into its run."""
    info = _build(store, "a")
    told = store.path(info) / FILE
    told.write_text(told.read_text().replace(info.created, created))
    return RunStore(store.folder.parent)


def test_a_stored_time_that_is_none_is_told(store):
    again = _dated(store, "gestern")
    assert again.all() == []
    (aside,) = again.set_aside()
    assert "created: found 'gestern', expected a time such as" in aside.reason


def test_a_run_of_the_future_is_told_once_and_stays_of_use(store):
    """The clock of the machine that recorded it may have been wrong; the run is not."""
    again = _dated(store, "2999-01-01T00:00:00.000+00:00")
    (info,) = again.all()
    assert info.warnings == ("stored on 2999-01-01, which was still to come: was a clock wrong?",)
    info.save(again.path(info))
    assert RunStore(store.folder.parent).all()[0].warnings == info.warnings


@pytest.mark.parametrize("created", ["2026-01-31T10:00:00.000+00:00", "2026-01-31T10:00:00"])
def test_a_run_of_the_past_is_not_spoken_of(store, created):
    assert _dated(store, created).all()[0].warnings == ()


def test_samples_that_were_announced_and_do_not_come(store):
    writer = store.start("x", channels(dq=True))
    with pytest.raises(ValueError, match="dq was announced"):
        writer.append(samples(3))
    writer.close("failed", "test")


def test_the_data_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("PA10D_DATA", str(tmp_path / "env"))
    assert RunStore().folder == tmp_path / "env" / "runs"
    assert RunStore(tmp_path / "given").folder == tmp_path / "given" / "runs"
    monkeypatch.delenv("PA10D_DATA")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "home"))
    assert RunStore().folder == tmp_path / "home" / "pa10d" / "runs"
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match=r"file: .*expected a folder for runs"):
        RunStore(tmp_path / "file")


def test_loading_forty_seconds_is_quick(store):
    with store.building("long", "x", channels(tuple("abcdefg"), dq=True, commands=True)) as writer:
        writer.append(samples(20_000, n=7, dq=True, commands=True))
    best = min(_timed(store) for _ in range(3))
    assert best < 0.2


def _timed(store):
    begin = time.process_time()
    recording = store.recording("long")
    assert recording.q.shape == (20_000, 7)
    return time.process_time() - begin


def test_tests_know_nothing_of_what_the_user_keeps():
    """A profile that somebody used last would be that of every command without one."""
    assert Path(tempfile.gettempdir()) in data_place().parents
    assert not data_place().is_relative_to(Path.home() / ".local")


def test_what_is_said_of_a_run_while_it_is_recorded_stays(store):
    writer = store.start("one", channels(), tags=("fit",))
    writer.append(samples(120))
    store.change("one", name="other", tags=("judge",))
    _build(store, "one")  # the name is free
    writer.close()
    info = store.find(writer.info.id)
    assert info == writer.info
    assert (info.name, info.tags) == ("other", ("judge",))
    assert (info.status, info.samples) == ("success", 120)


def test_what_is_said_of_a_run_that_the_disk_ends_stays(store):
    writer = store.start("one", channels())
    writer.append(samples(120))
    store.change("one", name="other")
    assert writer.salvage("no room").name == "other"
    assert store.find("other").status == "failed"


@pytest.mark.parametrize("renamed", ["one", "one-2"])
def test_who_renames_a_run_that_is_being_replaced_or_the_new_one_keeps_both(store, renamed):
    old = _build(store, "one", seed=1)
    writer = store.start("one", channels(), replace=True)
    writer.append(samples(120, seed=2))
    store.change(renamed, name="keep")
    writer.close()
    assert {info.id for info in store.all()} == {old.id, writer.info.id}
    assert store.find("keep").id == (old.id if renamed == "one" else writer.info.id)
    assert store.find("one").id == (writer.info.id if renamed == "one" else old.id)
    np.testing.assert_array_equal(store.read(old.id).samples.q, samples(120, seed=1).q)


def test_a_lock_that_is_not_let_go_keeps_no_run_from_its_end(store, monkeypatch):
    monkeypatch.setattr("pa10d.store.run_writer.PATIENCE", 0.05)
    writer = store.start("one", channels())
    writer.append(samples(120))
    with locked(store.folder):
        writer.close()
    assert store.find("one").status == "success"
