"""A force between two links pulls at both joints: what a law of one angle took of it is doubted."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from pa10d.diagnose.outcome import doubts
from pa10d.diagnose.unknown.structure import Structure
from pa10d.model import Term


@dataclass(frozen=True)
class Finding:
    term: Term = field(default_factory=lambda: Term("spring", (2,), np.ones(2)))
    sentence: str = "Joint 3 shows a spring."


def left_on(joint: int, *variables: str) -> Structure:
    none = np.zeros(0)
    return Structure(
        joint, variables, 0.9, 1.0, 0.0, (none,), none, None, none, 0.0, 0.9, 0.0
    )  # fmt: skip


def test_a_law_of_the_other_angle_may_be_its_share():
    said = doubts._or_one_force(Finding(), [left_on(3, "q3", "q4")]).sentence
    assert "Joint 4 keeps what depends on q3 and q4" in said
    assert "pulls at both joints" in said


@pytest.mark.parametrize(
    "left",
    [
        left_on(3, "q4"),  # of that joint alone
        left_on(3, "q4", "q5"),  # of others
        left_on(3, "dq4", "q3"),  # no force that stores energy
        left_on(2, "q3", "q4"),  # on the joint itself, where it is said already
    ],
)
def test_what_is_left_elsewhere_says_nothing_of_it(left):
    assert doubts._or_one_force(Finding(), [left]).sentence == Finding().sentence


def test_friction_stores_nothing():
    rubs = Finding(Term("stribeck", (2,), np.ones(1), {"vs": 0.1}), "Joint 3 shows Stribeck.")
    assert doubts._or_one_force(rubs, [left_on(3, "q3", "q4")]) == rubs
