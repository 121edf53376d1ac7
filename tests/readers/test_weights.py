"""What a packed file becomes is known before anything of it is unpacked."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import feather, parquet
from scipy.io import savemat
from test_formats import URDF

from pa10d.common.errors import UserError
from pa10d.readers import read_recording
from pa10d.readers.weights import size_of_arrow, size_of_mat, size_of_parquet
from pa10d.services.robots import load_robot

MANY = 10_000_000  # 80 MB a column
NOTHING = np.zeros(MANY)


def a_feather(folder):
    feather.write_feather(pa.table({"time": NOTHING}), folder / "b.feather", "zstd", chunksize=MANY)
    return folder / "b.feather"


def stream(folder):
    table = pa.table({"time": NOTHING})
    options = pa.ipc.IpcWriteOptions(compression="zstd")
    with (
        pa.OSFile(str(folder / "b.arrows"), "wb") as file,
        pa.ipc.new_stream(file, table.schema, options=options) as writer,
    ):
        writer.write_table(table)
    return folder / "b.arrows"


def lists(folder):
    """Twenty rows, each of half a million numbers."""
    table = pa.table({"time": np.arange(20.0), "q": pa.array([NOTHING[: MANY // 20]] * 20)})
    parquet.write_table(table, folder / "b.parquet", compression="zstd")
    return folder / "b.parquet"


def struct(folder):
    savemat(folder / "b.mat", {"log": {"arm": {"q": NOTHING}}}, do_compression=True)
    return folder / "b.mat"


def cell(folder):
    cells = np.empty((1, 1), dtype=object)
    cells[0, 0] = NOTHING
    savemat(folder / "c.mat", {"log": cells}, do_compression=True)
    return folder / "c.mat"


@pytest.mark.parametrize("bomb", [a_feather, stream, lists, struct, cell])
def test_bombs_are_refused_by_what_they_say(tmp_path, bomb, monkeypatch):
    path = bomb(tmp_path)
    assert path.stat().st_size < 1 << 20
    (tmp_path / "robot.urdf").write_text(URDF)
    monkeypatch.setattr("pyarrow.feather.read_table", lambda *a, **k: pytest.fail("unpacked"))
    monkeypatch.setattr("pyarrow.parquet.read_table", lambda *a, **k: pytest.fail("unpacked"))
    monkeypatch.setattr("scipy.io.loadmat", lambda *a, **k: pytest.fail("unpacked"))
    with pytest.raises(UserError, match=r"bytes become 8e\+07 bytes of numbers; expected a rec"):
        read_recording(path, *load_robot(tmp_path / "robot.urdf"))


def test_what_is_said_is_what_it_is(tmp_path):
    """Of open and packed buffers, several batches, dictionaries and both byte orders."""
    table = pa.table({"a": np.arange(5000.0), "b": pa.array(["x", "yy"] * 2500)})
    table = table.append_column("c", table["b"].dictionary_encode())
    for packing in (None, "lz4", "zstd"):
        path = tmp_path / f"{packing}.arrow"
        options = pa.ipc.IpcWriteOptions(compression=packing)
        with (
            pa.OSFile(str(path), "wb") as file,
            pa.ipc.new_file(file, table.schema, options=options) as writer,
        ):
            writer.write_table(table, max_chunksize=1000)
        assert size_of_arrow(path) == pytest.approx(table.nbytes, rel=0.1)
    parquet.write_table(table.select(["a"]), tmp_path / "a.parquet")
    assert size_of_parquet(parquet.read_metadata(tmp_path / "a.parquet")) == 40_000
    savemat(tmp_path / "a.mat", {"s": {"q": np.zeros((5000, 3))}}, do_compression=True)
    assert size_of_mat(tmp_path / "a.mat") == pytest.approx(120_000, rel=0.01)
    savemat(tmp_path / "4.mat", {"q": np.zeros((5000, 3))}, format="4")
    assert size_of_mat(tmp_path / "4.mat") == 0


@pytest.mark.parametrize("keep", [0.3, 0.6, 0.9])
def test_a_cut_arrow_file_is_one_line(tmp_path, keep):
    path = stream(tmp_path)
    raw = path.read_bytes()
    (tmp_path / "robot.urdf").write_text(URDF)
    robot = load_robot(tmp_path / "robot.urdf")
    for data in (raw[: int(keep * len(raw))], raw[:8] + b"\x7f" * 64 + raw[72:]):
        path.write_bytes(data)
        with pytest.raises(UserError, match=r"b.arrows: ") as told:
            read_recording(path, *robot)
        assert "\n" not in str(told.value)
