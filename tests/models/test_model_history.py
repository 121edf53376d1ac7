"""Versions: names, ids, parents; nothing is overwritten."""

from dataclasses import replace

import model_examples as examples
import pytest
from wrong_clock import HOUR, clock

from pa10d.common.errors import UserError
from pa10d.store.models import ModelStore

__all__ = ["clock"]


@pytest.fixture
def store(tmp_path):
    return ModelStore(tmp_path)


def test_a_taken_name_is_refused_and_nothing_changes(store):
    first = store.save(examples.textbook())
    before = store.path(first).read_bytes()
    with pytest.raises(UserError, match="there is one already; expected another name or --replace"):
        store.save(examples.textbook())
    assert store.path(first).read_bytes() == before
    assert len(store.all()) == 1


def test_replace_gives_the_name_away_and_keeps_the_old_file(store):
    first = store.save(examples.textbook())
    before = store.path(first).read_bytes()
    second = store.save(replace(examples.textbook(), cutoff=5.0), replace=True)
    assert store.load("m0").cutoff == 5.0
    assert store.load(first.id).cutoff == 9.5
    assert store.path(first).read_bytes() == before
    assert {info.id: info.replaced for info in store.all()} == {first.id: True, second.id: False}


def test_a_replaced_name_means_the_new_model_whatever_the_clock_says(store, clock):
    store.save(examples.textbook())
    clock.shift = -HOUR
    new = store.save(examples.textbook(), replace=True)
    assert store.find("m0").id == new.id
    assert [one.replaced for one in store.all()] == [True, False]


def test_name_id_and_unique_start(store):
    first, second = store.save(examples.textbook("a")), store.save(examples.textbook("b"))
    assert store.find(first.id).name == "a"
    common = next(k for k in range(99) if first.id[k] != second.id[k])
    assert store.find(first.id[: common + 1]).name == "a"
    with pytest.raises(UserError, match="2 ids begin so"):
        store.find(first.id[:common])
    with pytest.raises(UserError, match="model 'c': none of this name or id"):
        store.find("c")


def test_history_goes_from_the_first_ancestor(store):
    m0 = examples.textbook()
    m1 = examples.with_effects(m0, "stribeck")
    m2 = examples.with_effects(m1, "spring", name="m2")
    for model in (m0, m1, m2):
        store.save(model)
    line = store.history("m2")
    assert [(info.name, info.parent_name) for info in line] == [
        ("m0", None),
        ("m1", "m0"),
        ("m2", "m1"),
    ]
    assert line[2].change == "+ spring J2"
    assert line[1].parent == line[0].id
    assert store.load("m2").parent == line[1].id


def test_history_survives_the_replacement_of_an_ancestors_name(store):
    old = store.save(examples.textbook())
    store.save(examples.with_effects(examples.textbook(), "stribeck"))
    store.save(examples.textbook(), replace=True)
    assert store.history("m1")[0].id == old.id


def test_history_ends_where_the_ancestor_is_elsewhere(store):
    first = store.save(examples.textbook())
    store.save(examples.with_effects(examples.textbook(), "stribeck"))
    store.path(first).unlink()
    line = ModelStore(store.folder.parent).history("m1")
    assert [info.name for info in line] == ["m1"]
    assert line[0].parent_name == "m0"


def test_a_file_brought_from_elsewhere_is_a_model(store, tmp_path):
    path = store.path(store.save(examples.textbook()))
    other = ModelStore(tmp_path / "other")
    (other.folder / "from a friend.yaml").write_bytes(path.read_bytes())
    assert other.load("m0").name == "m0"


def test_a_parent_must_exist(store):
    with pytest.raises(UserError, match="model 'nobody'"):
        store.save(replace(examples.textbook(), parent="nobody"))
