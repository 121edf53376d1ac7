"""Of an exponent the data may say nothing; its law does, and what goes with it is as sure."""

from __future__ import annotations

import numpy as np
import pytest
from two_links import V0, recordings, state_of

from pa10d.diagnose.evidence import stated as errors
from pa10d.effects import effect
from pa10d.model import Term

LAW = {"vs": 0.05, "delta": 1.0}
EXPONENT = next(s for s in effect("stribeck").shapes if s.name == "delta")


def bump(t, q, dq, ddq):
    more = np.exp(-np.abs(dq[:, 0]) / LAW["vs"]) * np.tanh(dq[:, 0] / V0)
    return np.column_stack([more, np.zeros(len(t))])


def told(noise: float, of_law: bool = True) -> tuple[float, dict[str, float]]:
    """Errors of Fs, N·m, and of the law's shape under so much noise, N·m."""
    state = state_of(recordings(3, bump, noise))
    state.push(Term("stribeck", (0,), np.ones(1), dict(LAW)))
    state.refit()
    last = len(state.terms) - 1
    whole = errors.stated(state, [last], of_law)
    size = np.sqrt(np.diag(whole.covariance))[state.place(last)]
    return float(size[0]), whole.shape_errors[last]


def without_its_law(monkeypatch, noise: float) -> tuple[float, dict[str, float]]:
    monkeypatch.setattr(errors, "certain_before", lambda term, of_law: np.zeros(2))
    return told(noise)


def test_an_exponent_is_within_its_law_whatever_the_noise(monkeypatch):
    """Where it was as free as the noise left it, nothing of such friction was told: a size of
    0.99 ± 0.97 N·m, though the friction was there by all evidence."""
    size, shape = told(1.0)
    free_size, free_shape = without_its_law(monkeypatch, 1.0)
    assert shape["delta"] < 1.1 * EXPONENT.spread < 0.5 * free_shape["delta"]
    assert size < 0.6 * free_size
    assert not EXPONENT.determined(LAW["delta"], shape["delta"]), "but not by these data"


def test_what_the_data_tell_better_is_told_by_them(monkeypatch):
    size, shape = told(0.02)
    free_size, free_shape = without_its_law(monkeypatch, 0.02)
    assert (size, shape["delta"]) == pytest.approx((free_size, free_shape["delta"]), rel=0.01)
    assert EXPONENT.determined(LAW["delta"], shape["delta"])


def test_a_number_by_its_law_may_be_told_where_no_other_law_s_would():
    """Whether a finding has a number at all is asked by the law that was found for it."""
    size, shape = told(0.3)
    of_it, by_it = told(0.3, of_law=False)
    assert by_it["delta"] < 0.5 * shape["delta"], "only what reversals may have drawn it by"
    assert by_it["vs"] < 0.7 * shape["vs"]
    assert of_it < 0.7 * size
