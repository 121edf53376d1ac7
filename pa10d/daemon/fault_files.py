"""The last seconds before a fault, kept as a file that numpy opens."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.control.record import SCALARS, VECTORS
from pa10d.control.ring import Ring

SECONDS = 5.0
KEPT = 100


def keep_fault(data: Path, fault: dict[str, Any], ring: Ring, joints: Sequence[str]) -> Path | None:
    """Write DATA/faults/<time>-<kind>.npz: every field of the loop's records, and the fault."""
    folder = data / "faults"
    stop = int(fault.get("sequence") or ring.written) + 1
    rows, _ = ring.read(max(0, stop - round(SECONDS / ring.period)), stop)
    fields = {name: ring.layout.get(rows, name) for name in (*SCALARS, *VECTORS)}
    stamp = time.strftime("%Y%m%d-%H%M%S", time.gmtime())
    path = folder / f"{stamp}-{fault['kind']}.npz"
    with contextlib.suppress(OSError):
        folder.mkdir(exist_ok=True)
        about = json.dumps({"fault": fault, "joints": list(joints)})
        np.savez(path, about=np.array(about), **fields)  # type: ignore[arg-type]
        for old in sorted(folder.glob("*.npz"))[:-KEPT]:
            old.unlink(missing_ok=True)
        return path
    return None
