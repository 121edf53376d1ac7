"""Where a few steps from several bodies do not lead to one spring, others are begun from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from pa10d.diagnose.regression.flexible import JointSpring
from pa10d.diagnose.regression.passed import Guess
from pa10d.diagnose.search import springs, steps
from pa10d.diagnose.search.steps import Search
from pa10d.effects import effect


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


@dataclass(frozen=True)
class Left:
    """A state that leaves so many N·m on its two joints."""

    joint: int
    left: float
    frozen: bool = False

    def held_residual(self):
        return dict.fromkeys(range(2), np.full(4, self.left))


def joints_followed(monkeypatch, left: dict[int, float], gains: dict[int, float], floor):
    """The order of the states and the joints that were followed, of guesses with these gains."""
    monkeypatch.setattr(springs, "_open", lambda state, suspects: dict.fromkeys(left))
    monkeypatch.setattr(springs, "_starts", lambda state, guess: (guess.joint,))
    monkeypatch.setattr(
        springs, "_with_spring", lambda state, kind, joint: (left[joint], Left(joint, left[joint]))
    )
    guessed = [
        Guess(j, 1.0, 1.0, 0.0, np.zeros(1), gain, 0.5)
        for j, gain in sorted(gains.items(), key=lambda pair: -pair[1])
    ]
    states, followed = springs.with_springs(None, (), guessed, floor)
    return [s.joint for s in states], followed


FLOOR = np.full(2, 0.1)
GAINS = {1: 8966.0, 4: 7547.0, 2: 5765.0, 3: 423.0}


def test_a_spring_that_promises_nearly_as_much_is_followed_where_the_best_leaves_more(monkeypatch):
    """Promised third, and right: joint 2 was named, at twice its floor."""
    left = {1: 0.2, 4: 0.5, 2: 0.1, 3: 0.6}
    assert joints_followed(monkeypatch, left, GAINS, FLOOR) == ([2, 1, 4], {1, 4, 2})


def test_two_are_followed_where_one_of_them_leaves_noise(monkeypatch):
    left = {1: 0.1, 4: 0.5, 2: 0.1, 3: 0.6}
    assert joints_followed(monkeypatch, left, GAINS, FLOOR) == ([1, 4], {1, 4})
    unknown = joints_followed(monkeypatch, left, GAINS, np.full(2, np.nan))
    assert unknown == ([1, 4], {1, 4})  # nothing says that more is left


def test_a_spring_that_is_gone_for_good_is_not_found_again(monkeypatch):
    """Found, without a number, gone, found: a search that never ended."""
    offered = []
    monkeypatch.setattr(steps, "promising", lambda state, suspects, _: offered.append(suspects))
    monkeypatch.setattr(steps, "with_springs", lambda *_: ([], set()))
    spring, gap = effect("joint_elasticity"), effect("backlash")
    search = Search(Left(0, 1.0), [(spring, (0,)), (spring, (1,)), (gap, (0,))], 0)
    monkeypatch.setattr(search, "_most", lambda steps: steps)
    monkeypatch.setattr(search, "_forward", lambda *_: search.spring_beside(()))
    monkeypatch.setattr(search, "_without_unsure", lambda *_: set())
    search.go_on_without({("joint_elasticity", (0,))}, 4)
    assert offered == [[(spring, (1,)), (gap, (0,))]]
