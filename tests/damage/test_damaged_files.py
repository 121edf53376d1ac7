"""Thousands of damaged files: each is one line that says so, or is read; nothing else happens."""

from __future__ import annotations

import json
import os
import re
import shutil
import time
from pathlib import Path

import numpy as np
import pytest
from damage import damaged
from how_often import how_often
from model_examples import textbook
from store_data import ALL, channels, motion, plain_table, samples, write_csv

from pa10d.common.errors import UserError
from pa10d.control.record import SCALARS, VECTORS
from pa10d.dynamics import robot_from_urdf
from pa10d.services.explorer import faults
from pa10d.services.fault_records import read_fault
from pa10d.services.robots import load_robot
from pa10d.store import RunStore
from pa10d.store.csv_import import read_csv
from pa10d.store.models import ModelStore
from pa10d.store.run_info import BAG, FILE

PROFILES = Path(__file__).resolve().parents[2] / "profiles"
MOST = 20.0  # s for one file, on a machine that stands still now and then


def pytest_generate_tests(metafunc):
    if "seeds" in metafunc.fixturenames:
        count = how_often(metafunc.config, 20, 400)
        metafunc.parametrize("seeds", [range(count)], ids=[f"{count}-files"])


@pytest.fixture
def each(request):
    """What ``of_each`` does, counted in the report."""

    def counted(data, seeds, text, read):
        refused = of_each(data, seeds, text, read)
        request.node.user_properties += [("files", len(seeds)), ("refused", refused)]
        return refused

    return counted


def of_each(data, seeds, text, read):
    """``read(damaged bytes)`` for every seed: UserError of one line each, or nothing → how many
    were refused."""
    refused = 0
    for seed in seeds:
        broken = damaged(data, np.random.default_rng(seed), text)
        began = time.monotonic()
        try:
            read(broken)
        except UserError:
            refused += 1
        except Exception as error:
            raise AssertionError(f"seed {seed}: {type(error).__name__}: {error}") from error
        assert time.monotonic() - began < MOST, f"seed {seed}"
    return refused


@pytest.fixture
def run(tmp_path):
    store = RunStore(tmp_path / "data")
    writer = store.start("live", channels(**ALL))
    for k in range(6):
        writer.append(samples(40, start_ns=10**18 + k * 10**8, seed=k, **ALL))
        writer.flush()
    return store, writer.close()


@pytest.fixture(autouse=True)
def _nothing_else_is_touched(tmp_path, request):
    request.node.user_properties.append(("kind", "together"))
    before = {path.name for path in tmp_path.parent.iterdir()}
    (tmp_path / "beside").write_text("kept")
    yield
    assert (tmp_path / "beside").read_text() == "kept"
    assert {path.name for path in tmp_path.parent.iterdir()} == before


def test_bags_that_were_being_written(run, seeds, each):
    """Opening the store repairs them, or says why not; what it keeps can be read."""
    store, info = run
    bag, told = store.path(info) / BAG, store.path(info) / FILE
    whole = bag.read_bytes()

    def read(broken):
        bag.write_bytes(broken)
        info.but(status="started").save(store.path(info))
        again = RunStore(store.folder.parent)
        assert len(again.all()) + len(again.set_aside()) == 1
        assert json.loads(told.read_text())["status"] != "started"
        again.recording("live")

    assert each(whole, seeds, False, read) > 0


def test_bags_that_were_finished(run, seeds, each):
    store, info = run
    bag = store.path(info) / BAG

    def read(broken):
        bag.write_bytes(broken)
        store.recording("live")

    assert each(bag.read_bytes(), seeds, False, read) > 0


def test_descriptions_of_runs(run, seeds, each):
    store, info = run
    told = store.path(info) / FILE
    whole = told.read_bytes()

    def read(broken):
        told.write_bytes(broken)
        again = RunStore(store.folder.parent)
        assert len(again.all()) + len(again.set_aside()) == 1
        again.recording(info.id)

    assert each(whole, seeds, True, read) > 0


def test_models(tmp_path, seeds, each):
    store = ModelStore(tmp_path / "data")
    path = store.path(store.save(textbook()))
    whole = path.read_bytes()

    def read(broken):
        path.write_bytes(broken)
        again = ModelStore(tmp_path / "data")
        assert len(again.all()) + len(again.set_aside()) == 1
        again.load(again.find("m0"))

    assert each(whole, seeds, True, read) > 0


def test_profiles(tmp_path, seeds, each):
    shutil.copytree(PROFILES, tmp_path / "profiles")
    path = tmp_path / "profiles" / "pa10-7c.yaml"

    def read(broken):
        path.write_bytes(broken)
        load_robot(path)

    assert each(path.read_bytes(), seeds, True, read) > 0


def test_urdfs(seeds, each):
    urdf = PROFILES / "pa10_7c.urdf"
    whole = urdf.read_bytes()
    assert each(whole, seeds, True, lambda b: robot_from_urdf(b.decode("utf-8", "replace"))) > 0


@pytest.mark.parametrize("name", ["r.csv", "r.csv.gz"])
def test_csv(tmp_path, seeds, name, each):
    t, q, tau = motion(300)
    path = write_csv(tmp_path / name, plain_table(t, q, tau))

    def read(broken):
        path.write_bytes(broken)
        read_csv(path, 2, "arm")

    assert each(path.read_bytes(), seeds, not name.endswith("gz"), read) > 0


@pytest.fixture
def record(tmp_path):
    """The last seconds before a fault, as the daemon keeps them; a function that damages it."""
    folder = tmp_path / "data" / "faults"
    folder.mkdir(parents=True)
    fields = {name: np.zeros(20) for name in SCALARS}
    fields |= {name: np.zeros((20, 2)) for name in VECTORS} | {"time": np.arange(20) * 0.002}
    said = {"fault": {"kind": "stale", "joint": 2, "cause": "no news"}, "joints": ["a", "b"]}

    def write(**changed):
        given = {"about": np.array(json.dumps(said)), **fields, **changed}
        np.savez_compressed(
            folder / "20260101-000000-stale.npz",
            **{name: values for name, values in given.items() if values is not None},
        )
        return folder / "20260101-000000-stale.npz"

    return write


def test_last_seconds_before_faults(record, seeds, each):
    path = record()
    whole = path.read_bytes()

    def read(broken):
        path.write_bytes(broken)
        read_fault(path)

    each(whole, seeds, False, read)


@pytest.mark.parametrize(
    "changed",
    [
        {"q": np.zeros(20)},
        {"q": np.zeros((20, 7))},
        {"q": np.zeros((19, 2))},
        {"tau": np.array("x")},
        {"temperature": None},
        {"time": np.full(20, np.nan)},
        {"about": np.array("[]")},
        {"about": np.array('{"fault": {}, "joints": 3}')},
        {"state": np.zeros(100 << 20, np.uint8)},  # a hundred kilobytes in the file
    ],
    ids=lambda changed: next(iter(changed)),
)
def test_what_is_no_fault_record_is_passed_over(tmp_path, record, changed):
    with pytest.raises(UserError, match=r"20260101-000000-stale\.npz"):
        read_fault(record(**changed))
    assert faults(str(tmp_path / "data")).items == []


def test_a_pipe_among_the_faults_is_not_waited_for(tmp_path, record):
    path = record()
    os.mkfifo(path.with_name("20260101-000001-pipe.npz"))
    path.with_name("20260101-000002-link.npz").symlink_to(path)
    assert [one.id for one in faults(str(tmp_path / "data")).items] == [path.stem]


@pytest.mark.parametrize("mass", ["٣", "\u0663.5", "1_0", "nan", "1e999", "3½"])
def test_numbers_that_are_no_plain_numbers(mass):
    urdf = PROFILES / "pa10_7c.urdf"
    text = re.sub(r'<mass value="[^"]+"', f'<mass value="{mass}"', urdf.read_text(), count=1)
    assert mass in text
    with pytest.raises(UserError, match="mass"):
        robot_from_urdf(text)
