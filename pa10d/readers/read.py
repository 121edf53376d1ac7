"""Which reader a file or folder needs: by its name, and by its first bytes where those lie."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.dynamics.robot import Robot
from pa10d.profile import Profile
from pa10d.readers import archives, decimals, echoed, packed, text, vectors
from pa10d.readers.part import WHOLE, Part
from pa10d.readers.signatures import (
    BAGS,
    BINARY,
    MCAP,
    SQLITE,
    STREAM,
    is_can_csv,
    is_can_database,
    refuse_stand_in,
)  # fmt: skip
from pa10d.readers.table import ForeignTable, recording_of
from pa10d.store.column_guess import tells_time
from pa10d.store.column_mapping import read_mapping
from pa10d.store.csv_import import CsvRecording, read_columns, read_csv
from pa10d.store.csv_locate import is_comment, is_gzip
from pa10d.store.run_info import BAG
from pa10d.store.run_reader import read_run

Progress = Callable[[float], None]
CAN_LOGS = (".blf", ".asc", ".trc", ".mf4")
BY_NAME = (".mcap", ".db3", ".db", ".bag", ".mat", ".npz", ".npy", ".log", *CAN_LOGS)
PLAIN = (".csv", ".gz", "")
WITHIN = re.compile(r'"[^"\n]*,[^"\n]*"')
"""A comma between quotes."""
LOOK = 1 << 16  # bytes that are looked at to tell plain CSV from other text


def read_recording(
    path: Path,
    profile: Profile,
    robot: Robot,
    mapping: Sequence[str] = (),
    progress: Progress = lambda share: None,
    part: Part = WHOLE,
) -> CsvRecording:
    """Samples at equal steps; UserError names file, place and what was expected.

    mapping: ``COLUMN=FIELD`` options, see ``pa10d.store.column_mapping``; the profile's own stand
    behind them, as far as the file has their columns. progress: told the share that is read, of
    formats that take their time. part: of a file that holds several recordings.
    """
    if not path.exists():
        raise UserError(f"{path}: no such file; expected a recording")
    kept, constants = profile.map or [], profile.torque_constants
    rules = read_mapping(mapping, kept)
    if _is_plain_csv(path):
        part.only(path)
        return read_csv(path, robot.n, robot.name, constants, mapping, kept, robot.joint_names)
    table = _with_stamps(_table(path, profile, robot, progress, part))
    return recording_of(path, table, robot.n, robot.name, constants, rules, robot.joint_names)


def read_table(
    path: Path,
    profile: Profile,
    robot: Robot,
    progress: Progress = lambda share: None,
    part: Part = WHOLE,
) -> ForeignTable:
    """The columns as the file has them, before anybody says what they are."""
    if not path.exists():
        raise UserError(f"{path}: no such file; expected a recording")
    if _is_plain_csv(path):
        part.only(path)
        columns, remarks = read_columns(path)
        return ForeignTable(columns, remarks)
    return _with_stamps(_table(path, profile, robot, progress, part))


def _table(
    path: Path, profile: Profile, robot: Robot, progress: Progress, part: Part
) -> ForeignTable:
    if not path.is_dir() and archives.is_archive(path):
        with archives.unpacked_recording(path) as inner:
            return _said_of(path, inner, lambda: _table(inner, profile, robot, progress, part))
    if not path.is_dir() and packed.is_packed(path):
        head, suffix = packed.inner_head(path, LOOK), Path(packed.inner_name(path)).suffix.lower()
        if head.startswith(BINARY) or suffix in BY_NAME or is_can_csv(head):
            return _unpacked_table(path, profile, robot, progress, part)
        return text.read_text(path)
    return _table_of(path, profile, robot, progress, part)


def _unpacked_table(
    path: Path, profile: Profile, robot: Robot, progress: Progress, part: Part
) -> ForeignTable:
    with packed.unpacked_file(path) as plain:
        return _said_of(path, plain, lambda: _table_of(plain, profile, robot, progress, part))


def _said_of(path: Path, inner: Path, read: Callable[[], ForeignTable]) -> ForeignTable:
    """What is said of what was unpacked names the file that somebody has."""
    try:
        return read()
    except UserError as error:
        raise UserError(str(error).replace(str(inner), str(path))) from error


def _table_of(
    path: Path, profile: Profile, robot: Robot, progress: Progress, part: Part
) -> ForeignTable:
    from pa10d.readers import arrays, arrow, bags, can_logs, lerobot, matlab

    kind = path.suffix.lower()
    head = b"" if path.is_dir() else packed.first_bytes(path, 64)
    refuse_stand_in(path, head)
    if lerobot.is_data_set(path) or (head.startswith(b"PAR1") and lerobot.has_episodes(path)):
        part.only(path, episode=True)
        return lerobot.read_data_set(path, part.episode)
    if head.startswith(SQLITE) and is_can_database(path):
        part.only(path, topic=True)
        return can_logs.read_can_log(path, profile, ".db", part.topic)
    if path.is_dir() or kind in (".mcap", ".db3") or head.startswith(BAGS):
        part.only(path, topic=True)
        run = path / BAG if path.is_dir() else path
        mcap = run.is_file() and (kind == ".mcap" or packed.first_bytes(run, 5) == MCAP)
        own = _own(run) if mcap and part.topic is None else None
        return own or bags.read_bag(path, robot.joint_names, progress, part.topic)
    form = ".csv" if is_can_csv(head) else "candump" if _is_candump(path) else ""
    frames = form or kind in CAN_LOGS
    part.only(path, topic=bool(frames))
    if frames:
        return can_logs.read_can_log(path, profile, form, part.topic)
    if head.startswith((b"PAR1", b"ARROW1", STREAM)):
        return arrow.read_arrow(path)
    if kind == ".mat" or head.startswith(b"MATLAB") or matlab.is_hdf5(path):
        return matlab.read_mat(path, robot.joint_names)
    if kind in (".npz", ".npy") or head.startswith(b"\x93NUMPY"):
        return arrays.read_npz(path, robot.joint_names)
    return text.read_text(path)


def _is_candump(path: Path) -> bool:
    from pa10d.readers.candump import is_candump

    head = packed.first_bytes(path, 1024)
    return not head.startswith(BINARY) and is_candump(head)


def _own(path: Path) -> ForeignTable | None:
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
    return ForeignTable({**spread(content), **samples.extra})


def _with_stamps(table: ForeignTable) -> ForeignTable:
    """Seconds and nanoseconds in two columns are one time."""
    pairs = text.stamps_in_two(list(table.columns))
    if not pairs:
        return table
    columns = dict(table.columns)
    for sec, fine, unit in pairs:
        if "time" not in columns:
            whole = columns.pop(sec)
            columns = {"time": whole - whole[0] + columns.pop(fine) * unit, **columns}
    return ForeignTable(columns, table.remarks, table.parts)


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
    if head.startswith(BINARY) or is_can_csv(head):
        return False
    first, _, rest = head.partition(b"\n")
    try:
        line = first.decode("utf-8-sig")
    except UnicodeDecodeError:
        return False
    if "\0" in line or "\r" in line.rstrip("\r") or is_comment(line):
        return False
    names = [cell.strip() for cell in line.split(",")]
    if len(names) < 3 or any(sign in line for sign in (";", "\t")) or text.numbers(names):
        return False
    below = rest.partition(b"\n")[0].decode("utf-8", "replace")
    if text.numbers(names[:2]):
        return False  # a row, not names
    if not names[0] and not any(map(tells_time, names)):
        return False  # an index, which may be the time
    if echoed.names_its_joints(names) or any(map(vectors.is_vector, below.split(","))):
        return False
    if WITHIN.search(rest.decode("utf-8", "replace")):
        return False  # numbers with commas
    cells = below.split(",")
    if text.repeats(names) and not any(map(decimals.is_number, cells)):
        return False  # names in two rows
    if len(cells) != len(names) and below.strip() and not text.numbers(cells):
        return False  # lines above the names
    return not (text.stamps_in_two(names) or text.units_or_moments(below))
