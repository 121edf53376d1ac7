"""Recordings as CSV in the layout that ``pa10d run import`` reads."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np

from pa10d.measurement.recording import Recording


def write_csv(path: Path, run: Recording) -> None:
    """Write time, q1.., tau1.. and temp1.. where there are temperatures; .gz is compressed."""
    n = run.joints
    columns, names, formats = [run.t[:, None]], ["time"], ["%.4f"]
    parts = [("q", "%.7f", run.q), ("tau", "%.4f", run.tau), ("temp", "%.3f", run.temperature)]
    for name, form, values in parts:
        if values is not None:
            columns.append(values)
            names += [f"{name}{j}" for j in range(1, n + 1)]
            formats += [form] * n
    line = ",".join(formats) + "\n"
    body = "".join(line % tuple(row) for row in np.hstack(columns).tolist())
    data = (",".join(names) + "\n" + body).encode()
    # no time stamp inside: the same data set is the same file
    path.write_bytes(gzip.compress(data, 6, mtime=0) if path.suffix == ".gz" else data)
