"""How much is done: the whole study, or one short enough for every change of the code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Scope:
    """hidden: joints (from 1) whose friction rises towards standstill; boundary: parameters of the
    boundary velocity experiment; generations of the search; periods of the exciting motion and of
    the other one; cycles of the sines of 4 s and of 40 s."""

    hidden: tuple[int, ...]
    boundary: Mapping[str, Any]
    generations: int
    periods: int
    other: int
    cycles: int
    slow_cycles: int


WHOLE = Scope(
    hidden=(1, 2, 3, 4), boundary={"cycles": 8, "slow_cycles": 3}, generations=12, periods=4,
    other=2, cycles=5, slow_cycles=2,
)  # fmt: skip
QUICK = Scope(
    hidden=(2,), boundary={"cycles": 6, "slow_cycles": 1, "period": 3.2, "slow": 0.5},
    generations=2, periods=2, other=1, cycles=1, slow_cycles=1,
)  # fmt: skip
