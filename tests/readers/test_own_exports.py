"""Everything that ``run export`` writes comes back as it was."""

from __future__ import annotations

import numpy as np
import pytest
from test_formats import FILES, URDF

from pa10d.services.robots import load_robot
from pa10d.services.runs import import_run
from pa10d.store import RunStore
from pa10d.store.export import export_run


@pytest.fixture
def motion():
    t = np.arange(400) / 200.0
    q = np.stack([0.4 * np.sin(3 * t), 0.3 * np.cos(2 * t)], axis=1)
    return t, q, np.gradient(q, 1 / 200.0, axis=0), 5.0 * np.sin(3 * t)[:, None] * [1.0, 0.4]


@pytest.mark.parametrize("form", ["csv", "mcap", "parquet", "mat"])
def test_exported_and_imported_is_the_same(form, tmp_path, motion):
    (tmp_path / "robot.urdf").write_text(URDF)
    profile, robot = load_robot(tmp_path / "robot.urdf")
    store = RunStore(tmp_path / "data")
    first = import_run(store, FILES["bag folder, sqlite"](tmp_path, motion)[0], profile, robot).info
    out = tmp_path / f"out.{form}"
    export_run(store, first, form, out, replace=False)
    second = import_run(store, out, profile, robot, name="again").info
    a, b = store.read(first).samples, store.read(second).samples
    assert np.array_equal(a.q, b.q)
    assert np.array_equal(a.tau, b.tau)
    assert np.array_equal(a.dq, b.dq)
    plain = (lambda name: name.replace(".", "_")) if form == "mat" else str  # MATLAB's field names
    assert set(map(plain, a.extra)) == set(b.extra)
    assert np.array_equal(np.diff(a.stamps), np.diff(b.stamps))
