"""What no joint has less of than none is held at none where that foretells better."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from two_links import NAMES, VISCOUS, recordings, state_of, textbook

from pa10d.diagnose import procedure
from pa10d.diagnose.asked import one_effect
from pa10d.diagnose.evidence.stated import stated
from pa10d.diagnose.outcome.held import held_at_none, held_words
from pa10d.diagnose.search import none_at_least
from pa10d.diagnose.search.none_at_least import or_none_at_least
from pa10d.effects import Value
from pa10d.model import Term

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


def told(held):
    """What is said of a state that holds something at none."""
    model = replace(held.model, covariance=stated(held, ()).covariance)
    return held_words(held_at_none(model, held))


def test_why_it_is_held_is_said(driven):
    """It was "something else has drawn it, or they hardly show it", and of `add` nothing."""
    held = state_of(driven, textbook(driven), none_at_least=True)
    assert told(held) == (
        "viscous J2 is held at none: a fit to these runs wants surely less, which no joint has: "
        "something else has drawn it",
    )
    (index,) = held.at_none()
    beta = held.free.beta.copy()
    beta[held.place(index)] = -1e-4  # by chance
    held.free = replace(held.free, beta=beta)
    assert told(held) == (
        "viscous J2 is held at none: a fit to these runs wants less, which no joint has, but "
        "within its doubt: these runs hardly show it",
    )


class LooksTwice(Exception):
    """That it does is all that is asked."""


def test_one_suspicion_is_asked_twice_as_well(driven, monkeypatch):
    """It was asked with the free fit alone: other figures than those of a whole search."""

    def twice(*_):
        raise LooksTwice

    monkeypatch.setattr(procedure, "or_none_at_least", twice)
    made = [driven[name] for name in NAMES]
    with pytest.raises(LooksTwice):
        procedure.diagnose(textbook(driven), made[:2], made[2:], only=("torque_offset", (0,)))


def test_who_adds_an_effect_is_told_what_is_held(driven, monkeypatch):
    def held(begun, search, anew, searched):
        other = anew()
        return other, searched(other)

    monkeypatch.setattr(one_effect, "or_none_at_least", held)
    made = [driven[name] for name in NAMES]
    model = textbook(driven)
    _, said = one_effect.add(model, "torque_offset", (0,), made[:2], validate=made[2:], name="m1")
    assert "viscous J2 is held at none" in " ".join(said)


def test_where_nothing_is_below_none_all_is_as_it_was():
    runs = recordings(3)
    model = textbook(runs)
    free, held = state_of(runs, model), state_of(runs, model, none_at_least=True)
    assert held.free is None
    np.testing.assert_array_equal(held.fit.beta, free.fit.beta)


def looked(left, below=True, frozen=False, finds=0):
    """A search that keeps ``left`` of two joints held out, and found so many effects."""
    state = SimpleNamespace(
        frozen=frozen, model=SimpleNamespace(name="m0"), terms=["it"] * (3 + finds),
        below_none=lambda fit=None: [1] * below,
        held_residual=lambda: {j: np.full(4, v) for j, v in enumerate(left)},
    )  # fmt: skip
    return SimpleNamespace(state=state, fixed=3)


def asked(first, second, monkeypatch, surely=False, keeps=2.0, blunt=False):
    """Is the second search believed? surely: what is held is below none by its errors; keeps: times
    its noise floor, joint 2; blunt: its corner lies at the end of what it may be."""
    monkeypatch.setattr(none_at_least, "held_out", lambda *_: None)
    left = SimpleNamespace(ratio=np.array([1.0, keeps]))
    monkeypatch.setattr(none_at_least, "judged", lambda *_: left)
    value = Value(-0.084, 0.01, "N·m", determined=not surely, beyond=surely)
    corner = Value(0.01, 0.001, "rad/s", determined=not blunt, beyond=blunt)
    terms = [Term("coulomb", (j,), np.ones(1)) for j in range(3)]
    fitted = SimpleNamespace(terms=terms, term_values=lambda k: {"Fc": value, "v0": corner})
    monkeypatch.setattr(none_at_least, "snapshot", lambda *_: fitted)
    monkeypatch.setattr(none_at_least, "replace", lambda one, **others: (one, others))
    begun = SimpleNamespace(state=first.state, as_given="as it came", error="by that", model=None)
    found = or_none_at_least(begun, first, lambda: "anew", lambda one: second)
    if found == (begun, first):
        return False
    assert found == (("anew", {"as_given": "as it came", "error": "by that"}), second)
    return True


@pytest.mark.parametrize(
    ("first", "second", "taken"),
    [
        (looked([1.0, 0.5]), looked([0.9, 0.4]), True),
        (looked([1.0, 0.5]), looked([1.1, 0.2]), True),
        (looked([1.0, 0.5]), looked([0.99, 0.49]), False),  # no material difference
        (looked([1.0, 0.5]), looked([1.2, 0.5]), False),
        (looked([1.0, 0.5]), looked([1.2, 0.5], finds=1), False),  # noise may have drawn it
        (looked([1.0, 0.5], below=False), None, False),  # nothing to hold: not even tried
        (looked([1.0, 0.5], frozen=True), None, False),
    ],
)
def test_what_is_held_out_decides(first, second, taken, monkeypatch):
    assert asked(first, second, monkeypatch) == taken


@pytest.mark.parametrize(("keeps", "taken"), [(1.0, False), (np.nan, True), (1.5, True)])
def test_where_nothing_is_left_to_explain_it_is_not_made(keeps, taken, monkeypatch):
    second = looked([0.9, 0.4]) if taken else None
    assert asked(looked([1.0, 0.5]), second, monkeypatch, keeps=keeps) == taken


@pytest.mark.parametrize(
    ("before", "after", "taken"), [(0, 1, True), (0, 0, False), (1, 1, False), (1, 2, False)]
)
def test_what_friction_surely_below_none_hid_is_found(before, after, taken, monkeypatch):
    """The cogging of a motor, 72 times a turn, was drawn into a viscous friction of -0.084 N·m·s
    by the servo that answered it, and "nothing that was looked for shows itself" was said."""
    first, second = looked([0.0076, 0.1], finds=before), looked([0.012, 0.1], finds=after)
    assert asked(first, second, monkeypatch, surely=True, keeps=1.0) == taken
    assert not asked(first, second, monkeypatch, keeps=1.0, blunt=True)
