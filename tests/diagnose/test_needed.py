"""What came before another finding was well described, and is needless since, is left out."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from pa10d.diagnose.search import course, with_numbers
from pa10d.diagnose.search.with_numbers import needed_without_numbers
from pa10d.effects import Value
from pa10d.model import Term


def spring(joint: int) -> Term:
    return Term("joint_elasticity", (joint,), np.ones(1), {"K": 80.0, "zeta": 0.05})


def other(joint: int) -> Term:
    return Term("position_friction", (joint,), np.ones(2))


@dataclass
class State:
    """What a search leaves on two joints, with the first spring alone and with both."""

    alone: float
    terms: list[Term] = field(default_factory=lambda: [spring(0), spring(1)])

    def copy(self) -> State:
        return State(self.alone, list(self.terms))

    def drop(self, index: int) -> None:
        del self.terms[index]

    def held_residual(self) -> dict[int, np.ndarray]:
        left = 1.0 if len(self.terms) == 2 else self.alone
        return {0: np.ones(9), 1: np.full(9, left)}


@pytest.mark.parametrize("second", [spring, other])
@pytest.mark.parametrize(
    ("alone", "told", "kept"),
    [(1.0, False, 1), (1.04, False, 1), (1.5, False, 2), (1.0, True, 2)],
)
def test_what_has_no_number_has_to_be_missed(monkeypatch, second, alone, told, kept):
    """Position-dependent friction of 0.0137 ± 0.0147 was told beside a right line, too."""
    monkeypatch.setattr(
        with_numbers, "snapshot", lambda *_, **__: SimpleNamespace(term_values=lambda index: {})
    )
    monkeypatch.setattr(
        with_numbers, "not_one", lambda term, found: term.joints == (1,) and not told
    )
    state = State(alone, [spring(0), second(1)])
    search = SimpleNamespace(state=state, fixed=0, settle=lambda: None, floor=None)
    needed_without_numbers(search, None, [])
    assert [t.joints for t in search.state.terms] == [(0,), (1,)][:kept]


@pytest.mark.parametrize(
    ("alone", "floor", "kept"), [(1.2, 0.1, 1), (1.5, 0.1, 2), (1.2, 0.9, 2), (1.2, np.nan, 2)]
)
def test_what_has_no_number_and_takes_less_than_is_left_is_not_told(
    monkeypatch, alone, floor, kept
):
    """Friction that grows at rest was "Stribeck friction" for a fifth of its error, no number of
    it determined, with nine times the noise left."""
    monkeypatch.setattr(
        with_numbers, "snapshot", lambda *_, **__: SimpleNamespace(term_values=lambda index: {})
    )
    monkeypatch.setattr(with_numbers, "not_one", lambda term, found: term.joints == (1,))
    state = State(alone, [spring(0), other(1)])
    search = SimpleNamespace(
        state=state, fixed=0, settle=lambda: None, floor=np.array([1.0, floor])
    )
    needed_without_numbers(search, None, [])
    assert len(search.state.terms) == kept


def test_a_gap_that_passes_less_than_half_of_the_torque_is_none(monkeypatch):
    """ "Backlash" with a share of 0.42 ± 0.03 and no number stood for what a spring next to it
    left."""
    gap = Term("backlash", (1,), np.array([0.42]), {"b": 1e-3})
    share = {0.42: 0, 0.9: 1}
    for value, kept in share.items():
        told = {
            "share": Value(value, 0.5, "", random=0.03),
            "b": Value(1e-3, 6e-4, "rad", determined=False),
        }
        monkeypatch.setattr(
            with_numbers,
            "snapshot",
            lambda *_, told=told, **__: SimpleNamespace(term_values=lambda _: told),
        )
        state = State(1.5, [gap])
        search = SimpleNamespace(state=state, fixed=0, settle=lambda: None, floor=None)
        needed_without_numbers(search, None, [])
        assert len(search.state.terms) == kept


@pytest.mark.parametrize(("doubt", "kept"), [(1.2, 0), (0.3, 1)])
def test_a_spring_that_may_as_well_be_nothing_is_no_finding(monkeypatch, doubt, kept):
    """A servo "shows elasticity" was said beside a share of 1.44 ± 1.2 and no number."""
    unknown = Value(80.0, 900.0, "N·m/rad", determined=False)
    values = {"share": Value(1.44, doubt, ""), "K": unknown}
    monkeypatch.setattr(
        with_numbers, "snapshot", lambda *_, **__: SimpleNamespace(term_values=lambda index: values)
    )
    state = State(1.5, [spring(0)])
    search = SimpleNamespace(state=state, fixed=0, settle=lambda: None, floor=None)
    needed_without_numbers(search, None, [])
    assert len(search.state.terms) == kept


@pytest.mark.parametrize(("steps", "asked"), [(None, [1, 2]), (9, [1, 2]), (1, [])])
def test_what_was_in_the_way_of_another_is_looked_on_without(monkeypatch, steps, asked):
    """A gap of a real pendulum went for want of a number, and the spring that it had stood in for,
    better on both joints, was not asked again: 6.3 times the noise was left, and 2.2."""
    gone = iter([{("backlash", (0,))}, {("torque_delay", (0,))}, set()])
    told = []

    class Looking:
        steps = [None]

        def __init__(self, *_, **__): ...
        def run(self, steps): ...
        def swinging(self, joints):
            return False

        def go_on_without(self, refused, steps):
            told.append((set(refused), steps))

    monkeypatch.setattr(course, "Search", Looking)
    monkeypatch.setattr(course, "_keeps", lambda *_: [])
    monkeypatch.setattr(course, "needed_without_numbers", lambda *_: next(gone))
    for name in ("needed_beside_springs", "none_of_noise"):
        monkeypatch.setattr(course, name, lambda *_: None)
    begun = SimpleNamespace(
        state=None, given=0, error=SimpleNamespace(floor=SimpleNamespace(values=None)),
        model=None, as_given=[],
    )  # fmt: skip
    course._what_is_missing(begun, [], steps, lambda *_: None)
    assert [(len(refused), most) for refused, most in told] == [(n, steps) for n in asked]
