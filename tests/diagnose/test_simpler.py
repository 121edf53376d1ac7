"""A finding whose own part is zero by its errors may as well be the simpler effect inside it."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.diagnose.search.simpler import may_be_simpler

Q = np.sin(np.linspace(0.0, 20.0, 400)) + 0.3
SPRING, OFFSET = np.column_stack([Q, np.ones_like(Q)]), np.ones((len(Q), 1))
NOISE = np.diag([0.1, 0.1]) ** 2


@pytest.mark.parametrize(("stiffness", "may"), [(0.05, True), (0.15, True), (0.3, False)])
def test_a_spring_of_no_known_stiffness_may_be_an_offset(stiffness, may):
    assert may_be_simpler(np.array([stiffness, 1.0]), NOISE, SPRING, OFFSET) is may


def test_what_is_inside_may_take_over_what_it_is_confused_with():
    """Far from zero beside the stiffness as it is, the offset is not where that is free."""
    together = np.array([[1.0, -0.999], [-0.999, 1.0]])
    assert may_be_simpler(np.array([1.0, 1.0]), together, SPRING, SPRING[:, :1])
    assert not may_be_simpler(np.array([1.0, 3.0]), together, SPRING, SPRING[:, :1])


def test_what_does_not_lie_inside_is_no_part():
    beside = np.column_stack([Q**3])
    assert not may_be_simpler(np.zeros(2), NOISE, SPRING, beside)
    assert not may_be_simpler(np.zeros(2), NOISE, SPRING, SPRING)  # as many columns


def test_units_do_not_matter():
    for unit in (1e-6, 1.0, 1e6):
        scaled = np.array([0.05, 1.0]) / unit
        assert may_be_simpler(scaled, NOISE / unit**2, unit * SPRING, OFFSET)
