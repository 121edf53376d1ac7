"""``@pytest.mark.by_default("this", "that")``: of its cases these run without ``--long``."""

from __future__ import annotations

from collections.abc import Sequence

import pytest


def chosen(ids: Sequence[str], named: Sequence[str]) -> set[str]:
    """Those of the ids that are named, whole or by what they begin with before a dash.

    A name of none of them is refused: a law would run nowhere without a word.
    """
    found = {name: {i for i in ids if i == name or i.startswith(f"{name}-")} for name in named}
    lost = [name for name, its in found.items() if not its]
    if lost or not named:
        raise ValueError(f"by_default names no case: {', '.join(lost) or 'nothing'} of {list(ids)}")
    return set().union(*found.values())


@pytest.hookimpl(wrapper=True)
def pytest_pycollect_makeitem(collector):
    items = yield
    marked = [item for item in items or () if isinstance(item, pytest.Function)]
    marker = marked[0].get_closest_marker("by_default") if marked else None
    if marker is None:
        return items
    try:
        kept = chosen([_case(item) for item in marked], marker.args)
    except ValueError as error:
        raise pytest.UsageError(f"{marked[0].nodeid.split('[')[0]}: {error}") from None
    for item in marked:
        if _case(item) not in kept:
            item.add_marker(pytest.mark.long)
    return items


def _case(item: pytest.Function) -> str:
    return item.callspec.id if hasattr(item, "callspec") else ""
