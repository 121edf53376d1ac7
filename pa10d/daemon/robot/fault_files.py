"""The last seconds before a fault, kept as a file that numpy opens."""

from __future__ import annotations

import json
import logging
import os
import re
from collections.abc import Sequence
from pathlib import Path
from threading import Lock, Thread

import numpy as np

from pa10d.common.disk import writing
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.control.faults import Fault
from pa10d.control.record import SCALARS, VECTORS
from pa10d.control.ring import Ring
from pa10d.store.entries import own_folder
from pa10d.store.names import stamp_after

SECONDS = 5.0
KEPT = 100
_ONE_AT_A_TIME = Lock()  # a fault and the one that it brings come within a moment

log = logging.getLogger("pa10d.faults")


def keep_fault(data: Path, fault: Fault, ring: Ring, joints: Sequence[str]) -> Thread:
    """Write DATA/faults/<time>-<kind>.npz: every field of the loop's records, and the fault.

    The rows are taken now; a thread writes them, for nobody waits for a disk at such a time.
    """
    stop = (fault.sequence or ring.written) + 1
    rows, _ = ring.read(max(0, stop - round(SECONDS / ring.period)), stop)
    fields = {name: ring.layout.get(rows, name).copy() for name in (*SCALARS, *VECTORS)}
    about = json.dumps({"fault": fault.document(), "joints": list(joints)})
    thread = Thread(target=_write, args=(data / "faults", fault.kind, about, fields), daemon=True)
    try:
        thread.start()
    except RuntimeError as error:
        log.warning("%s; the fault's records were not kept", error)
    return thread


def _write(folder: Path, kind: str, about: str, fields: JsonObject) -> None:
    try:
        with _ONE_AT_A_TIME:
            own_folder(folder)
            path = folder / f"{stamp_after(os.listdir(folder))}-{_plain(kind)}.npz"
            _save(path, about, fields)
        for old in sorted(folder.glob("*.npz"))[:-KEPT]:
            old.unlink(missing_ok=True)
    except UserError as error:
        log.warning("%s; the fault's records were not kept", error)
    except OSError as error:
        log.warning("%s: %s; the fault's records were not kept", folder, error.strerror)


def _save(path: Path, about: str, fields: JsonObject) -> None:
    """The whole of it, or nothing."""
    try:
        with writing(path):
            np.savez(path, about=np.array(about), **fields)
    except BaseException:
        path.unlink(missing_ok=True)
        raise


def _plain(kind: str) -> str:
    return re.sub(r"[^a-z0-9_]+", "_", kind.lower())
