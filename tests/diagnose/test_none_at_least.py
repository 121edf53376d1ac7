"""What no joint has less of than none is held at none where that foretells better."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from two_links import VISCOUS, recordings, state_of, textbook

from pa10d.diagnose.evidence.stated import stated
from pa10d.diagnose.search.none_at_least import or_none_at_least

DRIVES = VISCOUS[1] + 0.3  # N·m·s/rad: more than the joint rubs


@pytest.fixture(scope="module")
def driven():
    """Runs of an arm whose joint 2 is driven by its speed: its viscous friction is below none."""
    return recordings(3, extra=lambda t, q, dq, ddq: np.column_stack([0 * t, -DRIVES * dq[:, 1]]))


def test_friction_that_a_fit_wants_below_none_is_none(driven):
    model = textbook(driven)
    free, held = state_of(driven, model), state_of(driven, model, none_at_least=True)
    (index,) = free.below_none()
    assert (free.terms[index].effect.id, free.terms[index].joints) == ("viscous", (1,))
    assert held.terms[index].coefficients == [0.0]
    assert (held.below_none(), held.at_none(), free.at_none()) == ([], [index], [])
    assert held.fit.rms()[1] > free.fit.rms()[1]
    np.testing.assert_allclose(held.free.beta, free.fit.beta)
    # the rest is fitted as if there were no such column
    bare = held.free.without(held.place(index))
    np.testing.assert_allclose(held.fit.beta, bare.beta, atol=1e-9)
    # bodies that can be are sought with every column
    np.testing.assert_array_equal(held.fit.triangle, held.free.triangle)
    # and that it is held there makes it no better known
    errors = [np.sqrt(np.diag(stated(one, ()).covariance)) for one in (held, free)]
    assert errors[0][held.place(index)] > 0.5 * errors[1][free.place(index)] > 0.0


def test_where_nothing_is_below_none_all_is_as_it_was():
    runs = recordings(3)
    model = textbook(runs)
    free, held = state_of(runs, model), state_of(runs, model, none_at_least=True)
    assert held.free is None
    np.testing.assert_array_equal(held.fit.beta, free.fit.beta)


def looked(left, below=True, frozen=False):
    """A search that keeps ``left`` of two joints held out."""
    state = SimpleNamespace(
        frozen=frozen, below_none=lambda fit=None: [0] * below,
        held_residual=lambda: {j: np.full(4, v) for j, v in enumerate(left)},
    )  # fmt: skip
    return SimpleNamespace(state=state)


@pytest.mark.parametrize(
    ("first", "second", "taken"),
    [
        (looked([1.0, 0.5]), looked([0.9, 0.4]), True),
        (looked([1.0, 0.5]), looked([1.1, 0.2]), True),
        (looked([1.0, 0.5]), looked([0.99, 0.49]), False),  # no material difference
        (looked([1.0, 0.5]), looked([1.2, 0.5]), False),
        (looked([1.0, 0.5], below=False), None, False),  # nothing to hold: not even tried
        (looked([1.0, 0.5], frozen=True), None, False),
    ],
)
def test_what_is_held_out_decides(first, second, taken, monkeypatch):
    monkeypatch.setattr(
        "pa10d.diagnose.search.none_at_least.replace", lambda one, **others: (one, others)
    )
    begun = SimpleNamespace(state=first.state, as_given="as it came", error="by that")
    other = SimpleNamespace(name="anew")
    found = or_none_at_least(begun, first, lambda: other, lambda one: second)
    if not taken:
        assert found == (begun, first)
    else:
        assert found == ((other, {"as_given": "as it came", "error": "by that"}), second)
