"""What a topic's messages said, kept as numbers: an hour at 1 kHz is 25 million of them."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.store.channels import Array

Found = Mapping[str, tuple[Sequence[str], Sequence[float]]]
"""position, velocity, effort -> names of joints and their values."""


class BagRows:
    """Messages that name the same quantities: one flat row of numbers each, in one order; stamps of
    their headers and of reception, ns."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self.names = names
        self.stamps, self.received, self.numbers = array("q"), array("q"), array("d")

    def table(self) -> Array:
        """(N, k), without a copy."""
        return np.frombuffer(self.numbers, dtype=np.float64).reshape(-1, len(self.names))

    def times(self, received: bool) -> NDArray[np.int64]:
        """(N,) ns, in the order in which they came."""
        return np.frombuffer(self.received if received else self.stamps, dtype=np.int64)


class BagTopic:
    """All messages of one topic. uneven: quantity -> messages whose values were not as many as
    their names."""

    def __init__(self) -> None:
        self.uneven: dict[str, int] = {}
        self._blocks: dict[tuple[str, ...], BagRows] = {}
        self._known: dict[tuple[str, ...], tuple[BagRows, list[int] | None]] = {}

    @property
    def blocks(self) -> list[BagRows]:
        """Those that say something."""
        return [block for block in self._blocks.values() if block.names]

    def joints(self, known: Sequence[str]) -> set[str]:
        """Those of a robot that it speaks of."""
        there = {name.rpartition(".")[0] for block in self.blocks for name in block.names}
        return there & set(known)

    def keep(self, found: Found, stamp: int, received: int) -> None:
        """One message; its joints may stand in any order, another one each time."""
        names: list[str] = []
        numbers: list[float] = []
        for kind, (joints, values) in found.items():
            if len(values) == len(joints):
                names += [f"{joint}.{kind}" for joint in joints]
                numbers += map(float, values)
            elif len(values):
                self.uneven[kind] = self.uneven.get(kind, 0) + 1
        key = tuple(names)
        known = self._known.get(key)
        block, order = known if known is not None else self._learnt(key)
        block.stamps.append(stamp)
        block.received.append(received)
        block.numbers.extend(numbers if order is None else [numbers[k] for k in order])

    def _learnt(self, key: tuple[str, ...]) -> tuple[BagRows, list[int] | None]:
        twice = next((name for name in key if key.count(name) > 1), None)
        if twice is not None:
            raise UserError(f"a message names {twice.rpartition('.')[0]} twice; expected each once")
        same = next((names for names in self._blocks if set(names) == set(key)), None)
        if same is None:
            self._blocks[key] = BagRows(key)
        block = self._blocks[same or key]
        order = None if block.names == key else [key.index(name) for name in block.names]
        self._known[key] = block, order
        return block, order
