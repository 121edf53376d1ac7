"""Loads behind a soft spring overshoot what is fitted to them: half of each step settles."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from pa10d.identify import loads

RIGHT = np.array([2.0, 0.3])


@dataclass(frozen=True)
class Seen:
    """What a model is to its loads."""

    h: np.ndarray
    terms: tuple = ()


class Pieces:
    """Of recordings; whoever looks at them sees the loads of a model."""

    model = Seen(RIGHT + 1.0)

    def look_through(self, model: Seen) -> None:
        """From now on."""
        self.model = model


def swings_back(pieces: Pieces, layout) -> Seen:
    """A fit that is nearly as far off as its loads were, on the other side: a spring's share came
    out at 0.87 and 0.67 in turns, and its joint at 4 times the noise."""
    return Seen(RIGHT - 0.95 * (pieces.model.h - RIGHT))


@pytest.mark.parametrize("springs", [True, False])
def test_loads_behind_a_spring_settle(monkeypatch, springs):
    monkeypatch.setattr(loads, "first_model", swings_back)
    layout = SimpleNamespace(follows_model=True, has_springs=springs, terms=())
    layout.with_shapes = lambda shapes: layout
    pieces = Pieces()
    loads.look_through_all(pieces, layout)
    off = np.max(np.abs(pieces.model.h - RIGHT))
    assert off < 0.01 if springs else off > 0.5
