"""What lies in the data folder is input: whatever is wrong is named, everything else goes on."""

from __future__ import annotations

import contextlib
import json
import os

import numpy as np
import pytest
from store_data import channels, samples

from pa10d.common.errors import Busy, UserError
from pa10d.common.yamlfile import read_yaml
from pa10d.store import RunStore
from pa10d.store.folders import locked
from pa10d.store.models import ModelStore
from pa10d.store.run_info import BAG, FILE

ALIAS_BOMB = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{k + 1}: &a{k + 1} [{', '.join([f'*a{k}'] * 10)}]\n" for k in range(9)
)


@pytest.fixture
def store(tmp_path):
    return RunStore(tmp_path)


@pytest.fixture
def run(store):
    return _build(store, "one")


def _build(store, name, **more):
    with store.building(name, "file", channels(), **more) as writer:
        writer.append(samples(120))
    return writer.info


def _rewrite(store, info, **changes):
    path = store.path(info) / FILE
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def _reopened(store):
    return RunStore(store.folder.parent)


def test_a_field_that_names_a_folder_deletes_nothing(store, run):
    models = store.folder.parent / "models"
    models.mkdir()
    (models / "kept.yaml").write_text("x")
    other = _build(store, "two")
    for wanted in ("../models", str(models), other.id, "."):
        _rewrite(store, run, replaces=wanted)
        again = _reopened(store)
        assert {info.name for info in again.all()} == {"one", "two"}
        assert (models / "kept.yaml").exists()


WRONG = {
    "joints is a text": {"joints": "abc"},
    "joints holds numbers": {"joints": [1, 2]},
    "negative samples": {"samples": -1},
    "samples is a text": {"samples": "many"},
    "a status of its own": {"status": "splendid"},
    "a name that is a path": {"name": "../../x"},
    "a name with a line break": {"name": "a\nb"},
    "an id that is a path": {"id": "../x"},
    "somebody else's id": {"id": "20200101-000000000-abcdef"},
    "tags is an object": {"tags": {"a": 1}},
    "repaired is a text": {"repaired": "perhaps"},
    "a list for a text": {"profile": ["p"]},
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_type_sets_one_run_aside(store, run, case):
    good = _build(store, "good")
    _rewrite(store, run, **WRONG[case])
    again = _reopened(store)
    assert [info.id for info in again.all()] == [good.id]
    (other,) = again.set_aside()
    assert (other.id, other.path) == (run.id, store.path(run))
    assert next(iter(WRONG[case])) in other.reason
    with pytest.raises(UserError, match=r"run\.json"):
        again.find(run.id)
    assert (store.path(run) / BAG).exists()


@pytest.mark.parametrize(
    "text", ["", "{", "null", "[]", "\xff", "[" * 100_000, '{"rate": 1e999}', "x" * (2 << 20)]
)
def test_a_description_that_is_none(store, run, text):
    (store.path(run) / FILE).write_text(text)
    again = _reopened(store)
    assert again.all() == []
    assert [other.id for other in again.set_aside()] == [run.id]


def test_links_and_pipes_are_not_opened(store, run, tmp_path):
    victim = tmp_path / "victim"
    victim.write_bytes(b"precious" * 1000)
    bag = store.path(run) / BAG
    bag.unlink()
    bag.symlink_to(victim)
    _rewrite(store, run, status="started")
    os.symlink(store.path(run), store.folder / "20200101-000000000-abcdef")
    pipe = store.folder / "20200101-000000000-fedcba"
    pipe.mkdir()
    os.mkfifo(pipe / FILE)
    (store.folder / "stray").write_text("")
    again = _reopened(store)
    assert victim.read_bytes() == b"precious" * 1000
    assert {other.id for other in again.set_aside()} == {
        "20200101-000000000-abcdef", "20200101-000000000-fedcba", "stray"
    }  # fmt: skip
    with pytest.raises(UserError, match="a link"):
        again.read(run.id)
    assert again.find("one").status == "failed"


def test_a_lock_that_is_a_link_leaves_its_target_alone(store, run, tmp_path):
    victim = tmp_path / "victim"
    victim.write_text("precious")
    lock = store.folder / ".lock"
    lock.unlink()
    lock.symlink_to(victim)
    with pytest.raises(UserError, match=r"\.lock"):
        store.change("one", tags=("a",))
    assert victim.read_text() == "precious"


def test_a_flipped_byte_in_an_unfinished_bag_ends_nothing(store):
    writer = store.start("live", channels())
    for k in range(5):
        writer.append(samples(50, start_ns=10**18 + k * 10**8, seed=k))
        writer.flush()
    writer.abandon()
    bag = store.path(writer.info) / BAG
    whole = bag.read_bytes()
    rng = np.random.default_rng(3)
    for place in rng.integers(8, len(whole), 60):
        _rewrite(store, writer.info, status="started")
        broken = bytearray(whole)
        broken[place] ^= 1 << int(rng.integers(8))
        bag.write_bytes(broken)
        again = _reopened(store)
        (info,) = again.repaired
        assert info.status == "failed"
        with contextlib.suppress(UserError):  # no checksum guards a topic's name
            assert len(again.read(info).samples) == info.samples
        kept = bag.with_suffix(".cut")
        rest = kept.read_bytes() if kept.exists() else b""
        sound = bag.read_bytes()
        assert bytes(broken).endswith(rest)
        cut_at = len(broken) - len(rest)
        assert sound[:cut_at] == bytes(broken[:cut_at])
        assert not rest or cut_at <= place
        kept.unlink(missing_ok=True)


def test_a_finished_run_whose_bag_lost_samples_says_so(store):
    writer = store.start("x", channels())
    for k in range(4):
        writer.append(samples(50, start_ns=10**18 + k * 10**8, seed=k))
        writer.flush()
    info = writer.close()
    bag = store.path(info) / BAG
    data = bytearray(bag.read_bytes())
    data[len(data) // 2] ^= 1
    bag.write_bytes(data)
    with pytest.raises(UserError, match=r"found (50|100) sound samples, expected 200"):
        store.read("x")


def test_a_run_that_is_deleted_while_it_is_wanted(store, run):
    store.delete("one")
    with pytest.raises(UserError, match="it has been deleted"):
        store.read(run)


def test_a_lock_that_is_never_given_back_is_waited_for_no_longer_than_said(store, run, monkeypatch):
    monkeypatch.setattr("pa10d.store.folders.PATIENCE", 0.2)
    with locked(store.folder):
        with pytest.raises(Busy, match=f"process {os.getpid()} has held it"):
            store.change("one", tags=("a",))
        _rewrite(store, run, status="started")
        assert _reopened(store).repaired == []  # opening goes on; the next one repairs
    assert [info.name for info in _reopened(store).repaired] == ["one"]


@pytest.mark.parametrize(
    "text", [ALIAS_BOMB, "a: &a [*a]", "[" * 100_000, "{a: " * 5000, "a: !!timestamp x", "a: \x00",
             "a: !!int ''", "a: !!bool x", "a: !!float ''", "? [a]\n: b", "a: 0x", "id: 1e999999"]
)  # fmt: skip
def test_a_model_file_that_is_a_trap_sets_itself_aside(tmp_path, text):
    store = ModelStore(tmp_path)
    path = store.folder / "trap.yaml"
    path.write_text(text)
    assert store.all() == []
    (other,) = store.set_aside()
    assert str(path) in other.reason
    with pytest.raises(UserError, match=r"trap\.yaml"):
        read_yaml(path) and store.find("trap")


def test_aliases_that_stay_small_are_welcome(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("usual: &usual {gear: 50}\ndrives: [{<<: *usual, node: 1}, *usual]\n")
    assert read_yaml(path).data["drives"] == [{"gear": 50, "node": 1}, {"gear": 50}]


def test_a_model_file_that_is_a_pipe_or_a_link_is_not_opened(tmp_path):
    store = ModelStore(tmp_path)
    os.mkfifo(store.folder / "pipe.yaml")
    os.symlink("/dev/zero", store.folder / "zero.yaml")
    (store.folder / "folder.yaml").mkdir()
    assert {other.id for other in store.set_aside()} == {"pipe", "zero", "folder"}


def test_a_replaced_run_stays_until_the_new_one_has_ended_well(store, run):
    for status in ("stopped", "aborted", "failed"):
        writer = store.start("one", channels(), replace=True)
        assert store.find("one").id == run.id
        writer.append(samples(10))
        info = writer.close(status, "for a reason")
        assert info.name.startswith("one-")
        assert "run 'one' was kept" in store.find(info.id).reason
        assert store.find("one").id == run.id
    writer = store.start("one", channels(), replace=True)
    writer.append(samples(10))
    writer.abandon()  # its recorder is killed
    _reopened(store)
    assert store.find("one").id == run.id
    writer = store.start("one", channels(), replace=True)
    writer.append(samples(10))
    info = writer.close()
    assert (info.name, store.find("one").id) == ("one", writer.info.id)
    assert not (store.folder / run.id).exists()
    assert len([other for other in store.all() if other.name == "one"]) == 1
