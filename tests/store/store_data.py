"""Runs and CSV files for the tests of the store."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np

from pa10d.store import Channels, CommandedMotion, Samples

NAMES = ("S1", "S2", "E1")


def samples(count=500, n=3, rate=500.0, seed=0, start_ns=1_700_000_000_000_000_001, **have):
    """Random numbers at odd nanoseconds; ``have``: dq, commands, temperature, current, extra."""
    rng = np.random.default_rng(seed)
    stamps = start_ns + np.rint(np.arange(count) * (1e9 / rate)).astype(np.int64)

    def block():
        return rng.normal(size=(count, n))

    return Samples(
        stamps,
        block(),
        block(),
        dq=block() if have.get("dq") else None,
        commands=CommandedMotion(block(), block(), block()) if have.get("commands") else None,
        temperature=block() if have.get("temperature") else None,
        current=block() if have.get("current") else None,
        extra={name: rng.normal(size=count) for name in have.get("extra", ())},
    )


def channels(names=NAMES, **have):
    return Channels(
        names,
        velocity=have.get("dq", False),
        commands=have.get("commands", False),
        temperature=have.get("temperature", False),
        current=have.get("current", False),
        extra=tuple(have.get("extra", ())),
    )


ALL = {
    "dq": True,
    "commands": True,
    "temperature": True,
    "current": True,
    "extra": ("motor torque [Nm]", "motor_torque_Nm", "7", "phase"),
}


def motion(count=400, n=2, rate=200.0, seed=0):
    """Smooth positions and torques with noise: (t, q, tau)."""
    rng = np.random.default_rng(seed)
    t = np.arange(count) / rate
    phase = t[:, None] * (1 + np.arange(n))
    return t, np.sin(phase), 10 * np.cos(phase) + 0.1 * rng.normal(size=(count, n))


def write_csv(path: Path, table: dict, header=None, rows=None) -> Path:
    """Columns as a CSV file (gzipped where the name says so)."""
    names = list(table) if header is None else header
    columns = [[repr(float(v)) if not isinstance(v, str) else v for v in c] for c in table.values()]
    lines = [",".join(names), *(",".join(row) for row in zip(*columns, strict=True))]
    data = ("\n".join(lines if rows is None else rows(lines)) + "\n").encode()
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)
    return path


def plain_table(t, q, tau):
    """time,q1..,tau1.."""
    table = {"time": t}
    table |= {f"q{j + 1}": column for j, column in enumerate(q.T)}
    return table | {f"tau{j + 1}": column for j, column in enumerate(tau.T)}
