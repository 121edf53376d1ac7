"""Anything that can evaluate tasks elsewhere, seen as a map."""

from __future__ import annotations

from typing import Any

from pa10d.trajectory.excitation.search import Mapper


def as_mapper(where: Any = None) -> Mapper:
    """A ``map`` that returns results in order.

    where: None for this process; a function such as a pool's ``map``; an executor of
    ``concurrent.futures``; or a client whose ``map`` gives futures that its ``gather`` collects
    (Dask).
    """
    if where is None:
        return map
    if hasattr(where, "gather") and hasattr(where, "map"):
        # equal tasks of another search must be computed again: a cluster would remember them
        return lambda function, tasks: where.gather(where.map(function, list(tasks), pure=False))
    if hasattr(where, "submit"):
        return lambda function, tasks: where.map(function, tasks)
    return where
