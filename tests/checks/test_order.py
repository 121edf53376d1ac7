"""Columns of another joint are told by the arm's geometry, with the line that puts them right."""

from __future__ import annotations

import numpy as np
import pytest
from one_ur5e import recorded, ur5e

from pa10d.checks.order import check_order
from pa10d.measurement.recording import Recording
from pa10d.services.mending import in_words_of, mends


@pytest.fixture(scope="module")
def robot():
    return ur5e()


@pytest.fixture(scope="module")
def clean():
    return recorded(15.0)


def _dealt(run, order, moved=("q", "tau")):
    places = [j - 1 for j in order]
    q = run.q[:, places] if "q" in moved else run.q
    tau = run.tau[:, places] if "tau" in moved else run.tau
    return Recording("dealt", run.t, q, tau)


def test_every_joint_in_its_place_is_silent(clean, robot):
    assert list(check_order(clean, robot)) == []


@pytest.mark.by_default("order0")
@pytest.mark.parametrize(
    ("order", "moved"),
    [
        ((3, 2, 1, 4, 5, 6), ("q", "tau")),  # by the alphabet: elbow before shoulder
        ((6, 5, 4, 3, 2, 1), ("q", "tau")),
        ((2, 3, 4, 5, 6, 1), ("q", "tau")),
        ((1, 2, 4, 3, 5, 6), ("tau",)),
    ],
)
def test_an_order_is_named_and_put_right_by_its_mends(clean, robot, order, moved):
    wrong = _dealt(clean, order, moved)
    (found,) = check_order(wrong, robot)
    assert found.code == "order"
    given = {mend.field: mend.source for mend in found.mends}
    for kind, right, block in (("q", clean.q, wrong.q), ("tau", clean.tau, wrong.tau)):
        for j in range(6):
            source = given.get(f"{kind}{j + 1}", f"{kind}{j + 1}")
            assert np.array_equal(block[:, int(source[-1]) - 1], right[:, j])


def test_the_line_has_the_file_s_columns_and_their_units(clean, robot):
    (found,) = check_order(_dealt(clean, (1, 3, 2, 4, 5, 6), ("q",)), robot)
    called = {f"q{j}": f"pos{j - 1}" for j in range(1, 7)}
    said = {f"pos{j}": "deg" for j in range(6)}
    own = in_words_of(found, called, said, 6)
    assert own.advice == "--map 'pos2[deg]=q2' 'pos1[deg]=q3'"
    assert [(c.column, c.field, c.unit) for c in mends(found, called, said, 6)] == [
        ("pos2", "q2", "deg"), ("pos1", "q3", "deg"),
    ]  # fmt: skip
