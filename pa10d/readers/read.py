"""Which reader a file or folder needs: by its name, and by its first bytes where those lie."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pa10d.common.errors import UserError
from pa10d.dynamics.robot import Robot
from pa10d.profile import Profile
from pa10d.readers import packed, text
from pa10d.readers.table import Table, recording_of
from pa10d.store.column_mapping import read_mapping
from pa10d.store.csv_import import CsvRecording, read_columns, read_csv
from pa10d.store.csv_locate import is_gzip
from pa10d.store.run_info import BAG
from pa10d.store.run_reader import read_run

Progress = Callable[[float], None]
CAN_LOGS = (".blf", ".asc", ".trc")
BINARY = (b"\x89MCAP", b"SQLite format 3", b"#ROSBAG", b"PAR1", b"ARROW1", b"MATLAB", b"\x89HDF",
          b"\x93NUMPY", b"PK\x03\x04", b"LOGG", b"\xff\xff\xff\xff")  # fmt: skip
"""How files begin that are no text."""
BY_NAME = (".mcap", ".db3", ".bag", ".mat", ".npz", ".npy", ".log", *CAN_LOGS)
PLAIN = (".csv", ".gz", "")
LOOK = 1 << 16  # bytes that are looked at to tell plain CSV from other text


def read_recording(
    path: Path,
    profile: Profile,
    robot: Robot,
    mapping: Sequence[str] = (),
    progress: Progress = lambda share: None,
) -> CsvRecording:
    """Samples at equal steps; UserError names file, place and what was expected.

    mapping: ``COLUMN=FIELD`` options, see ``pa10d.store.column_mapping``; the profile's own stand
    behind them, as far as the file has their columns. progress: told the share that is read, of
    formats that take their time.
    """
    if not path.exists():
        raise UserError(f"{path}: no such file; expected a recording")
    kept, constants = profile.map or [], profile.torque_constants
    rules = read_mapping(mapping, kept)
    if _is_plain_csv(path):
        return read_csv(path, robot.n, robot.name, constants, mapping, kept, robot.joint_names)
    table = _table(path, profile, robot, progress)
    return recording_of(path, table, robot.n, robot.name, constants, rules, robot.joint_names)


def read_table(
    path: Path, profile: Profile, robot: Robot, progress: Progress = lambda share: None
) -> Table:
    """The columns as the file has them, before anybody says what they are."""
    if not path.exists():
        raise UserError(f"{path}: no such file; expected a recording")
    if _is_plain_csv(path):
        columns, remarks = read_columns(path)
        return Table(columns, remarks)
    return _table(path, profile, robot, progress)


def _table(path: Path, profile: Profile, robot: Robot, progress: Progress) -> Table:
    if not path.is_dir() and packed.is_packed(path):
        head, suffix = packed.inner_head(path, 16), Path(packed.inner_name(path)).suffix.lower()
        if head.startswith(BINARY) or suffix in BY_NAME:
            return _unpacked_table(path, profile, robot, progress)
        return _with_stamps(text.read_text(path))
    return _table_of(path, profile, robot, progress)


def _unpacked_table(path: Path, profile: Profile, robot: Robot, progress: Progress) -> Table:
    with packed.unpacked_file(path) as plain:
        try:
            return _table_of(plain, profile, robot, progress)
        except UserError as error:
            raise UserError(str(error).replace(str(plain), str(path))) from error


def _table_of(path: Path, profile: Profile, robot: Robot, progress: Progress) -> Table:
    from pa10d.readers import arrays, bags, can_logs

    kind = path.suffix.lower()
    if path.is_dir():
        if (path / "meta" / "info.json").is_file():
            return _lerobot(path)
        if (path / BAG).is_file():
            return _own(path / BAG) or bags.read_bag(path, robot.joint_names, progress)
        return bags.read_bag(path, robot.joint_names, progress)
    head = packed.first_bytes(path, 16)
    if kind == ".mcap" or head.startswith(b"\x89MCAP"):
        return _own(path) or bags.read_bag(path, robot.joint_names, progress)
    if kind == ".db3" or head.startswith((b"SQLite format 3", b"#ROSBAG")):
        return bags.read_bag(path, robot.joint_names, progress)
    if head.startswith((b"PAR1", b"ARROW1", arrays.STREAM)):
        return arrays.read_arrow(path)
    if kind == ".mat" or head.startswith(b"MATLAB") or arrays.is_hdf5(path):
        return arrays.read_mat(path)
    if kind in (".npz", ".npy") or head.startswith(b"\x93NUMPY"):
        return arrays.read_npz(path)
    if kind in CAN_LOGS or (kind == ".log" and head.startswith(b"(")):
        return can_logs.read_can_log(path, profile)
    return _with_stamps(text.read_text(path))


def _own(path: Path) -> Table | None:
    """A run that this program exported, exactly; None where it is somebody else's bag."""
    from pa10d.readers.arrays import spread

    try:
        run = read_run(path)
    except UserError:
        return None
    if "pa10d.run" not in run.metadata:
        return None
    samples = run.samples
    content = {
        "time": (samples.stamps - run.time_zero_ns) * 1e-9, "q": samples.q, "tau": samples.tau,
        "dq": samples.dq, "temperature": samples.temperature, "current": samples.current,
    }  # fmt: skip
    return Table({**spread(content), **samples.extra})


def _lerobot(path: Path) -> Table:
    """A LeRobot data set of version 3: its first episode."""
    import numpy as np

    from pa10d.readers.arrays import read_arrow

    files = sorted((path / "data").glob("**/*.parquet"))
    if not files:
        raise UserError(f"{path}: no data/**/*.parquet; expected a LeRobot data set")
    try:
        info = json.loads((path / "meta" / "info.json").read_text())
        version, features = info.get("codebase_version"), info.get("features")
    except (ValueError, AttributeError) as error:
        raise UserError(f"{path}/meta/info.json: {error}; expected JSON") from error
    table = read_arrow(files[0])
    columns = _named_features(table.columns, features)
    remarks = [f"a LeRobot data set ({version})"]
    if "episode_index" in columns:
        first = columns["episode_index"] == columns["episode_index"][0]
        count = len(np.unique(columns["episode_index"]))
        columns = {name: values[first] for name, values in columns.items()}
        remarks.append(f"the first of {count} episodes in {files[0].name}")
    if "timestamp" in columns:
        columns["time"] = columns.pop("timestamp")
    return Table(columns, remarks)


def _named_features(columns: Mapping[str, Any], features: object) -> dict[str, Any]:
    """Each entry of a feature by the name that the data set has for it."""
    called: dict[str, str] = {}
    for feature, about in features.items() if isinstance(features, dict) else ():
        names = about.get("names") if isinstance(about, dict) else None
        while isinstance(names, dict) and len(names) == 1:  # {"motors": […]}
            names = next(iter(names.values()))
        if isinstance(names, list) and len(set(map(str, names))) == len(names):
            called |= {f"{feature}{k}": f"{feature}.{name}" for k, name in enumerate(names, 1)}
    return {called.get(name, name): values for name, values in columns.items()}


def _with_stamps(table: Table) -> Table:
    """Seconds and nanoseconds in two columns are one time."""
    columns = dict(table.columns)
    for sec, nano in text.stamps_in_two(list(columns)):
        if "time" not in columns:
            whole = columns.pop(sec)
            columns = {"time": whole - whole[0] + columns.pop(nano) * 1e-9, **columns}
    return Table(columns, table.remarks)


def _is_plain_csv(path: Path) -> bool:
    """Commas, UTF-8, a header in the first line and numbers below it: the reader for it names the
    wrong cell."""
    if path.is_dir() or path.suffix.lower() not in (*PLAIN, ".txt"):
        return False
    gzipped = is_gzip(path)
    if not gzipped and packed.is_packed(path):
        return False
    try:
        head = packed.inner_head(path, LOOK)
    except UserError:
        return gzipped  # said with the line at which it ends
    if head.startswith(BINARY):
        return False
    first, _, rest = head.partition(b"\n")
    try:
        line = first.decode("utf-8-sig")
    except UnicodeDecodeError:
        return False
    if "\0" in line or line.lstrip().startswith(text.COMMENT):
        return False
    names = [cell.strip() for cell in line.split(",")]
    if len(names) < 3 or any(sign in line for sign in (";", "\t")) or text.numbers(names):
        return False
    below = rest.partition(b"\n")[0].decode("utf-8", "replace")
    return not (text.stamps_in_two(names) or text.units_or_moments(below))
