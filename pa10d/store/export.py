"""Runs as files for other programs: CSV, MCAP, Parquet, MATLAB."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.store.channels import Array
from pa10d.store.run_info import BAG, RunInfo
from pa10d.store.run_reader import StoredRun
from pa10d.store.runs import RunStore

_EXACT = 2**53  # ns


def export_run(store: RunStore, info: RunInfo, form: str, out: Path, replace: bool) -> None:
    """Write ``out`` whole or not at all; an existing file only gives way to ``replace``."""
    writers: dict[str, Callable[[StoredRun, RunInfo, Path], None]] = {
        "csv": _write_csv,
        "parquet": _write_parquet,
        "mat": _write_mat,
    }
    if out.is_dir():
        raise UserError(f"{out}: a folder; expected the name of a file")
    if out.exists() and not replace:
        raise UserError(f"{out}: exists already; expected another --out or --replace")
    fresh = out.with_name(f".{out.name}.{os.getpid()}")
    try:
        if form == "mcap":
            shutil.copyfile(store.path(info) / BAG, fresh)
        else:
            writers[form](store.read(info), info, fresh)
        fresh.replace(out)
    except OSError as error:
        raise UserError(f"{out}: {error.strerror or error}; nothing was written") from error
    finally:
        fresh.unlink(missing_ok=True)


def columns(run: StoredRun) -> dict[str, Array]:
    """Every channel but the stamps as columns, under the names that an import knows."""
    samples = run.samples
    out: dict[str, Array] = {}
    blocks = {"q": samples.q, "dq": samples.dq, "tau": samples.tau, "i": samples.current}
    blocks["temp"] = samples.temperature
    if samples.commands is not None:
        sent = samples.commands
        blocks |= {"q_cmd": sent.q, "dq_cmd": sent.dq, "tau_cmd": sent.tau}
    for name, block in blocks.items():
        if block is not None:
            out |= {f"{name}{j + 1}": column for j, column in enumerate(block.T)}
    return {**out, **samples.extra}


def _table(run: StoredRun, exact_time: bool) -> Any:
    """``exact_time``: decimal text to the nanosecond, needed where float64 falls short."""
    import pyarrow as pa

    ns = run.samples.stamps - run.time_zero_ns
    time: Any = pa.array(ns * 1e-9)
    if exact_time and np.abs(ns).max() >= _EXACT:
        whole, rest = np.divmod(ns, 1_000_000_000)
        time = pa.array([f"{s}.{r:09d}" for s, r in zip(whole, rest, strict=True)])
    named = {name: pa.array(np.ascontiguousarray(v)) for name, v in columns(run).items()}
    return pa.table({"time": time, **named})


def _write_csv(run: StoredRun, info: RunInfo, out: Path) -> None:
    from pyarrow import csv

    with out.open("wb") as file:
        table = _table(run, exact_time=True)
        head = ",".join(_quoted(name) for name in table.column_names)
        file.write(f"{head}\n".encode())
        options = csv.WriteOptions(include_header=False, quoting_style="none")
        csv.write_csv(table, file, options)


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"' if set(name) & set(',"\r\n') else name


def _write_parquet(run: StoredRun, info: RunInfo, out: Path) -> None:
    from pyarrow import parquet

    notes = {"name": info.name, "id": info.id, "joints": ",".join(run.joints)}
    notes |= {"profile": info.profile, "software": info.software, "created": info.created}
    table = _table(run, exact_time=False).replace_schema_metadata(notes)
    parquet.write_table(table, out, compression="zstd")


def _write_mat(run: StoredRun, info: RunInfo, out: Path) -> None:
    from scipy.io import savemat

    samples = run.samples
    content: JsonObject = {
        "time": ((samples.stamps - run.time_zero_ns) * 1e-9)[:, None],
        "q": samples.q,
        "tau": samples.tau,
        "joints": np.array(run.joints, dtype=object),
        "info": {"name": info.name, "id": info.id, "profile": info.profile,
                 "created": info.created, "software": info.software},
    }  # fmt: skip
    optional = {"dq": samples.dq, "current": samples.current, "temperature": samples.temperature}
    content |= {name: block for name, block in optional.items() if block is not None}
    if samples.commands is not None:
        sent = samples.commands
        content["command"] = {"q": sent.q, "dq": sent.dq, "tau": sent.tau}
    if samples.extra:
        content["extra"] = _fields(samples.extra)
    with out.open("wb") as file:
        savemat(file, content, long_field_names=True, do_compression=True)


def _fields(extra: Any) -> dict[str, Array]:
    """MATLAB's field names are letters, digits and underscores, 63 at most."""
    named: dict[str, Array] = {}
    for name, values in extra.items():
        plain = "".join(c if c.isascii() and c.isalnum() else "_" for c in name)[:58]
        plain = plain if plain[:1].isalpha() else f"x{plain}"
        while plain in named:
            plain += "_"
        named[plain] = values[:, None]
    return named
