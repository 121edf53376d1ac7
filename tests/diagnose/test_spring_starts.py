"""Where a few steps from several bodies do not lead to one spring, others are begun from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from pa10d.diagnose.regression.flexible import JointSpring
from pa10d.diagnose.search import springs


@dataclass(frozen=True)
class End:
    springs: tuple[JointSpring, ...]
    left: float
    beta: np.ndarray


def spring(stiffness: float) -> JointSpring:
    return JointSpring(0, stiffness, 3.0, 0.1)


class Valley:
    """A few steps lead from a start to where ``FEW`` says, many to the end of that valley."""

    FEW: dict[float, float] = {}
    LEFT = {735.0: -13.4, 896.0: -6.3, 1170.0: -22.3}
    asked: list[float] = []

    def __init__(self, *_):
        pass

    def fit(self, beta, of, steps):
        start = of[0].stiffness
        self.asked.append(start)
        end = start if steps > 3 else self.FEW.get(start, start)
        return End((spring(end),), self.LEFT.get(end, 0.0), beta)


@pytest.fixture(autouse=True)
def valleys(monkeypatch):
    monkeypatch.setattr(springs, "Flexible", Valley)
    monkeypatch.setattr(springs, "_there", lambda state: {})
    Valley.asked = []


def begun(*stiff: float):
    return [(np.zeros(1), (spring(k),)) for k in stiff]


def test_the_other_kind_is_tried_and_the_better_end_taken(monkeypatch):
    monkeypatch.setattr(Valley, "FEW", {721.0: 735.0, 722.0: 896.0, 1443.0: 1170.0})
    found = springs._followed(None, begun(721.0, 722.0), begun(1443.0))
    assert found.springs[0].stiffness == 1170.0


def test_one_end_of_all_is_enough(monkeypatch):
    monkeypatch.setattr(Valley, "FEW", {721.0: 735.0, 722.0: 735.0, 1443.0: 1170.0})
    found = springs._followed(None, begun(721.0, 722.0), begun(1443.0))
    assert found.springs[0].stiffness == 735.0
    assert 1443.0 not in Valley.asked
