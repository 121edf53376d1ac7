"""What columns without names may be, from their values: stamps rise, speeds are slopes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pa10d.store.channels import Array
from pa10d.store.column_choices import Choice

ALIKE = 0.9  # correlation of a slope and a speed; chosen, not measured
NEAR = 0.2  # of the positions' size, by which a wanted position differs from them; chosen
LOOK = 20_000  # samples that are looked at


def guessed_by_value(columns: Mapping[str, Array], n: int) -> list[Choice]:
    """Stamps, then blocks of n in the order in which most write them: positions, speeds where they
    are slopes, torques. Nothing where the columns do not come in blocks of n behind the stamps."""
    names = [name for name, values in columns.items() if np.isfinite(values).all()]
    clock = next((name for name in names if _rises(columns[name])), None)
    rest = [name for name in names if name != clock]
    if clock is None or len(rest) % n or len(rest) < 2 * n:
        return []
    t = columns[clock][:LOOK]
    blocks = [rest[k : k + n] for k in range(0, len(rest), n)]
    values = [np.stack([columns[name][:LOOK] for name in block], axis=1) for block in blocks]
    q, others = values[0], range(1, len(blocks))
    slopes = np.gradient(q, t, axis=0) if (np.diff(t) > 0).all() else np.zeros_like(q)
    speeds = [k for k in others if _alike(values[k], slopes)]
    torques = [k for k in others if k not in speeds and not _near(values[k], q)]
    if not torques:
        return []
    found = {"q": 0, "tau": torques[0]} | ({"dq": speeds[0]} if speeds else {})
    return [
        Choice(clock, "time"),
        *(
            Choice(name, f"{field}{j}")
            for field, k in found.items()
            for j, name in enumerate(blocks[k], 1)
        ),
    ]


def one_block(names: Sequence[str]) -> bool:
    """Whether the columns are numbered and nothing else: one matrix of whatever name."""
    bare = [name.rstrip("0123456789") for name in names]
    return len(set(bare)) == 1 and all(map(str.__gt__, names, bare))


def _rises(values: Array) -> bool:
    steps = np.diff(values)
    return bool(len(steps) and (steps >= 0).all() and values[-1] > values[0])


def _near(one: Array, other: Array) -> bool:
    """Whether one follows the other, number by number, in most joints; (N, n) each."""
    size = np.sqrt(np.mean((other - other.mean(axis=0)) ** 2, axis=0))
    apart = np.sqrt(np.mean((one - other) ** 2, axis=0))
    return bool(np.median(apart - NEAR * size) < 0)


def _alike(one: Array, other: Array) -> bool:
    """Whether most joints' courses go together; (N, n) each."""
    a, b = one - one.mean(axis=0), other - other.mean(axis=0)
    size = np.sqrt((a * a).sum(axis=0) * (b * b).sum(axis=0))
    moved = size > 0
    if not moved.any():
        return False
    return bool(np.median((a * b).sum(axis=0)[moved] / size[moved]) > ALIKE)
