"""LeRobot data sets: many episodes over many Parquet files, one of which is a recording."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.readers.archives import is_archive
from pa10d.readers.arrays import damaged
from pa10d.readers.arrow import spread_arrow
from pa10d.readers.packed import first_bytes
from pa10d.readers.part import Parts
from pa10d.readers.table import ForeignTable
from pa10d.readers.weights import refuse_growth, size_of_parquet
from pa10d.store.channels import Array
from pa10d.store.column_guess import WORDS

INFO = Path("meta") / "info.json"
EPISODE, FRAME, STAMP = "episode_index", "frame_index", "timestamp"
TOLERANCE = 1e-4  # s by which LeRobot itself lets stamps be off their frame
SHARES = 100.0  # LeRobot's drivers write positions as −100 … 100 of a joint's range, too
STATE = "observation.state"


def is_data_set(folder: Path) -> bool:
    """Versions 2 and 3 alike."""
    return (folder / INFO).is_file()


def has_episodes(path: Path) -> bool:
    """Whether a Parquet file is one of a data set's, wherever it lies."""
    import pyarrow as pa
    from pyarrow import parquet

    if first_bytes(path, 4) != b"PAR1":
        return False
    try:
        return EPISODE in parquet.read_schema(path).names
    except (pa.ArrowException, OSError):
        return False  # said by who reads all of it


def episodes_of(path: Path) -> dict[int, int]:
    """Episode -> its frames, of a data set's folder or of one of its files."""
    if not path.exists():
        raise UserError(f"{path}: no such file; expected a recording")
    if path.is_file() and is_archive(path):
        raise UserError(f"{path}: packed; --episode all expects the data set's folder (unpack it)")
    if not is_data_set(path) and (path.is_dir() or not has_episodes(path)):
        raise UserError(f"{path}: no episodes; --episode all expects a LeRobot data set")
    return {episode: sum(held.values()) for episode, held in _where(_files(path)).items()}


def read_data_set(path: Path, episode: int | None = None) -> ForeignTable:
    """One episode, its columns by the names of the features; without a number the longest."""
    info = _info(path)
    held = _where(_files(path))
    frames = {number: sum(parts.values()) for number, parts in held.items()}
    if not frames:
        raise UserError(f"{path}: no frames; expected a data set with episodes")
    told = f"{min(frames)} … {max(frames)}" if len(frames) > 1 else f"{min(frames)}"
    if episode is not None and episode not in frames:
        raise UserError(
            f"{path}: no episode {episode} in the {len(frames)} that are here, expected {told}"
        )
    taken = max(frames, key=frames.__getitem__) if episode is None else episode
    columns = _named_features(_columns(held[taken], taken), info.get("features"))
    fps = info.get("fps")
    time, remarks = _time(columns, float(fps) if isinstance(fps, int | float) else 0.0)
    columns = {"time": time, **{k: v for k, v in columns.items() if k not in (STAMP, EPISODE)}}
    which = f"a LeRobot data set ({info.get('codebase_version', 'without meta/info.json')})"
    which += f": episode {taken}"
    if episode is None and len(frames) > 1:
        which += f", the longest of {len(frames)}"
    total = info.get("total_episodes")
    if isinstance(total, int) and total > len(frames) and path.is_dir():
        remarks.append(f"{total} episodes by meta/info.json, {len(frames)} of them are here")
    rate = float(fps) if isinstance(fps, int | float) and fps > 0 else 0.0
    there = {str(number): _words(number, count, rate) for number, count in frames.items()}
    parts = Parts("episode", there, str(taken)) if len(there) > 1 else None
    return ForeignTable(columns, [which, *remarks, *_shares(columns)], parts)


def _words(episode: int, frames: int, fps: float) -> str:
    return f"{episode} · {frames / fps:.3g} s" if fps else f"{episode} · {frames} frames"


def _files(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    files = sorted((path / "data").glob("**/*.parquet"))
    if not files:
        raise UserError(f"{path}: no data/**/*.parquet; expected a LeRobot data set")
    return files


def _info(path: Path) -> Mapping[str, Any]:
    """Of the folder, or of the data set that a file lies in; empty where that is gone."""
    folders = [path] if path.is_dir() else list(path.absolute().parents)[:4]
    found = next((folder / INFO for folder in folders if (folder / INFO).is_file()), None)
    if found is None:
        return {}
    try:
        info = json.loads(found.read_text())
    except (ValueError, OSError) as error:
        raise UserError(f"{found}: {error}; expected JSON") from error
    if not isinstance(info, dict):
        raise UserError(f"{found}: found {type(info).__name__}; expected a JSON object")
    return info


def _where(files: Sequence[Path]) -> dict[int, dict[Path, int]]:
    """Episode -> files that hold it, each with how many of its frames."""
    import pyarrow as pa
    from pyarrow import parquet

    held: dict[int, dict[Path, int]] = {}
    for file in files:
        try:
            if EPISODE not in parquet.read_schema(file).names:
                raise UserError(f"{file}: no column {EPISODE}; expected a LeRobot data set")
            refuse_growth(file, size_of_parquet(parquet.read_metadata(file)))
            found = parquet.read_table(file, columns=[EPISODE])[EPISODE]
            if found.null_count or not pa.types.is_integer(found.type):
                raise UserError(f"{file}: column {EPISODE}: expected whole numbers, none missing")
            numbers = found.to_numpy()
        except (pa.ArrowException, OSError) as error:
            raise damaged(file, "a Parquet file of a LeRobot data set", error) from error
        for number, count in zip(*np.unique(numbers, return_counts=True), strict=True):
            held.setdefault(int(number), {})[file] = int(count)
    return dict(sorted(held.items()))


def _columns(held: Mapping[Path, int], episode: int) -> dict[str, Array]:
    """The episode's numbers, in the order of its frames; pictures stay where they are."""
    import pyarrow as pa
    from pyarrow import parquet

    parts = []
    for file in held:
        schema = parquet.read_schema(file)
        names = [field.name for field in schema if not pa.types.is_struct(field.type)]
        chosen = [(EPISODE, "=", episode)]
        try:
            parts.append(parquet.read_table(file, columns=names, filters=chosen))
        except (pa.ArrowException, OSError) as error:
            raise damaged(file, "a Parquet file of a LeRobot data set", error) from error
    try:
        whole = pa.concat_tables(parts, promote_options="default")
    except pa.ArrowException as error:
        raise damaged(next(iter(held)), "files with the same columns", error) from error
    columns = spread_arrow(next(iter(held)), whole)
    order = columns.get(FRAME)
    if order is None or (np.diff(order) > 0).all():
        return columns
    rows = np.argsort(order, kind="stable")
    return {name: values[rows] for name, values in columns.items()}


def _time(columns: Mapping[str, Array], fps: float) -> tuple[Array, list[str]]:
    """Stamps are kept in 32 bits; where they are the frames' own they are taken from those."""
    frames, stamps = columns.get(FRAME), columns.get(STAMP)
    if frames is not None and fps > 0:
        exact = (frames - frames[0]) / fps
        if stamps is None:
            return exact, [f"no column {STAMP}: {fps:g} frames a second, by meta/info.json"]
        apart = np.abs(stamps - stamps[0] - exact).max()
        if apart <= TOLERANCE:
            return exact, []
        return stamps, [
            f"stamps are up to {apart:.3g} s off the {fps:g} frames a second of meta/info.json: "
            "the stamps are believed"
        ]
    if stamps is None:
        raise UserError(f"no column {STAMP}, and no fps with {FRAME}; expected a LeRobot data set")
    return stamps, []


def _shares(columns: Mapping[str, Array]) -> list[str]:
    others = "|".join(words for field, words in WORDS.items() if field != "q")
    state = [
        values
        for name, values in columns.items()
        if name.startswith(STATE) and not re.search(others, name.replace(".", " "), re.I)
    ]
    largest = max((float(np.abs(values).max()) for values in state), default=0.0)
    if 2 * np.pi < largest <= SHARES * (1 + 1e-6):
        return [
            f"{STATE} reaches {largest:.4g}: degrees, or −100 … 100 of each joint's range, as "
            "LeRobot's drivers write unless told use_degrees; no torque model can use the latter"
        ]
    return []


def _named_features(columns: Mapping[str, Array], features: object) -> dict[str, Array]:
    """Each entry of a feature by the name that the data set has for it."""
    called: dict[str, str] = {}
    for feature, names in _names(features):
        numbered = [f"{feature}{k}" for k in range(1, len(names) + 1)]
        if len(names) == 1 and feature in columns:
            numbered = [feature]
        if (
            all(name in columns for name in numbered)
            and f"{feature}{len(names) + 1}" not in columns
        ):
            own = (f"{feature}.{name}" for name in names)
            called |= dict(zip(numbered, own, strict=True))
    return {called.get(name, name): values for name, values in columns.items()}


def _names(features: object) -> Iterator[tuple[str, list[str]]]:
    """Features whose entries have a name each, all different."""
    for feature, about in features.items() if isinstance(features, dict) else ():
        names = about.get("names") if isinstance(about, dict) else None
        while isinstance(names, dict) and len(names) == 1:  # {"motors": […]}
            names = next(iter(names.values()))
        if isinstance(names, list) and len(set(map(str, names))) == len(names):
            yield str(feature), list(map(str, names))
