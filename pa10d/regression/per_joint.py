"""Rows of the joints' equations: standstill masks differ between joints, so each has its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
T = TypeVar("T", bound=np.generic)
Mask = NDArray[np.bool_]
PerJoint = dict[int, Array]
"""Rows of each joint's equation that count, (m_j, …); joints without a column are absent."""


def gathered(per_run: Sequence[NDArray[T]], keep: Sequence[Mask], joint: int) -> NDArray[T]:
    """(m_j, …): of runs (M, …), one after the other, the rows that count for a joint; keep (M, n)
    of each run."""
    return np.concatenate([x[k[:, joint]] for x, k in zip(per_run, keep, strict=True)])


def assembled(
    parts: Sequence[tuple[slice, PerJoint]], size: int, counts: Sequence[int]
) -> PerJoint:
    """joint -> (m_j, size): columns of several parts, each in its place, zeros where a part has
    none for a joint; counts: m_j of every joint."""
    out = {j: np.zeros((count, size)) for j, count in enumerate(counts)}
    for place, part in parts:
        for j, columns in part.items():
            out[j][:, place] = columns
    return out


def rms(rows: Array) -> float:
    """Of rows (m,) of one joint; zero of none."""
    return float(np.sqrt(np.mean(rows**2))) if len(rows) else 0.0


def predict(columns: PerJoint, beta: Array) -> PerJoint:
    """Torque per joint (m_j,) of given columns and coefficients."""
    return {j: c @ beta for j, c in columns.items()}
