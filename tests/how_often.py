"""How often a test tries what it draws at random."""

from __future__ import annotations

import pytest


def how_often(config: pytest.Config, few: int, many: int) -> int:
    """few by default; many, or as many as asked for, with ``--long``."""
    if not config.getoption("--long"):
        return few
    return config.getoption("--trials") or many
