"""Per-joint figures as one table of records: what the compiled step reads.

Compiled code takes a table as one argument where separate arrays would be dozens: that is most of
the compile time. Every joint is one record; its fields keep the names of the arrays they come from.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Table = NDArray[np.void]
Record = Any


def table(*parts: NamedTuple) -> Table:
    """(n,) records with one field for every array (n, ...) of the parts."""
    columns = {name: np.asarray(a) for part in parts for name, a in part._asdict().items()}
    if len(columns) != sum(len(part) for part in parts):
        raise ValueError("two parts use the same name")
    dtype = np.dtype([(name, a.dtype, a.shape[1:]) for name, a in columns.items()], align=True)
    out = np.zeros(len(next(iter(columns.values()))), dtype)
    for name, a in columns.items():
        out[name] = a
    return out


def blank(n: int, **shapes: tuple[int, ...]) -> Table:
    """(n,) records of zeros with fields of these shapes."""
    return np.zeros(n, np.dtype([(name, np.float64, shape) for name, shape in shapes.items()]))
