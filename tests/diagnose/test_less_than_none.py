"""Friction below nothing stands for what is missing, where nothing else was found."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from pa10d.diagnose.search import less_than_none
from pa10d.diagnose.search.less_than_none import or_without_impossible
from pa10d.effects import Value
from pa10d.model import Term

COULOMB, VISCOUS = (Term(kind, (0,), np.ones(1)) for kind in ("coulomb", "viscous"))
RIPPLE = Term("torque_ripple", (0,), np.ones(2))
COVARIANCE = np.diag([1.0, 2.0, 3.0, 4.0])


@dataclass(frozen=True)
class Model:
    """Two bodies' unknowns, and the textbook's friction."""

    viscous: float = -0.084
    terms: tuple[Term, ...] = (COULOMB, VISCOUS)
    covariance: np.ndarray = field(default_factory=lambda: COVARIANCE)
    standard: object = None
    feasible: bool = True

    def term_slice(self, index):
        return slice(2 + index, 3 + index)

    def term_values(self, index):
        value = (0.3, self.viscous)[index]
        name = ("Fc", "Fv")[index]
        return {name: Value(value, 0.01, "N·m·s/rad", determined=value > 0, beyond=value < 0)}


@dataclass(frozen=True)
class Begun:
    whole: Model
    as_given: str = "as it came"
    error: str = "by that"

    @property
    def model(self):
        return self.whole


def looked(terms, fixed, frozen=False):
    return SimpleNamespace(state=SimpleNamespace(terms=terms, frozen=frozen), fixed=fixed)


@pytest.fixture(autouse=True)
def as_fitted(monkeypatch):
    monkeypatch.setattr(less_than_none, "snapshot", lambda given, *_: given)


def asked(model, first, second=None):
    begun, tried = Begun(model), []

    def anew(other):
        tried.append(other)
        return Begun(other, "anew", "anew")

    return or_without_impossible(begun, first, anew, lambda _: second), tried


def test_what_friction_below_nothing_hid_is_found_without_it():
    """The cogging of a motor, 72 times a turn, was drawn into a viscous friction of -0.084 N·m·s
    by the servo that answered it, and "nothing that was looked for shows itself" was said."""
    found, (other,) = asked(Model(), looked((COULOMB, VISCOUS), 2), looked((COULOMB, RIPPLE), 1))
    assert other.terms == (COULOMB,)
    np.testing.assert_array_equal(other.covariance, np.diag([1.0, 2.0, 3.0]))
    assert not other.feasible
    assert found.search.state.terms == (COULOMB, RIPPLE)
    assert (found.begun.as_given, found.begun.error) == ("as it came", "by that")
    assert found.words == (
        "viscous J1: Fv comes out at -0.084 N·m·s/rad, and nothing has less than none: that is no "
        "estimate, but where something else has drawn it",
    )


@pytest.mark.parametrize(
    ("model", "first", "second"),
    [
        (Model(viscous=0.084), looked((COULOMB, VISCOUS), 2), None),
        (Model(), looked((COULOMB, VISCOUS, RIPPLE), 2), None),
        (Model(), looked((COULOMB, VISCOUS), 2, frozen=True), None),
        (Model(), looked((COULOMB, VISCOUS), 2), looked((COULOMB,), 1)),
    ],
)
def test_otherwise_the_search_is_as_it_was(model, first, second):
    found, tried = asked(model, first, second)
    assert found.search is first
    assert found.words == ()
    assert bool(tried) == (second is not None)
