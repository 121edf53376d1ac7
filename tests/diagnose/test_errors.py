"""Standard errors against the scatter of many simulated repetitions."""

from __future__ import annotations

import numpy as np
import pytest
from bare_sides import ar1
from how_often import how_often
from two_links import recordings, state_of, textbook

from pa10d.diagnose.evidence.errors_of import full_covariance, honest_covariance, term_covariance
from pa10d.diagnose.search.steps import Search
from pa10d.effects import effect
from pa10d.model import Term

COLOURS = {"white": None, "coloured": lambda rng, n: ar1(rng, n, 0.99)}
SPRING = np.array([2.0, 0.6])  # k, k·q0
BUMP = (1.0, 0.3, 1.5)  # Fs, vs, delta


def spring(t, q, dq, ddq):
    return np.column_stack([np.zeros(len(t)), SPRING[0] * q[:, 1] - SPRING[1]])


def bump(t, q, dq, ddq):
    fs, vs, delta = BUMP
    speed = np.abs(dq[:, 0])
    return np.column_stack([fs * np.exp(-((speed / vs) ** delta)) * np.sign(dq[:, 0]), 0 * t])


@pytest.mark.long
@pytest.mark.parametrize("colour", [pytest.param("white", marks=pytest.mark.long), "coloured"])
def test_errors_of_coefficients_are_their_scatter(colour, pytestconfig):
    model, away, whole = None, [], []
    repeats = how_often(pytestconfig, 15, 30)
    for seed in range(repeats):
        runs = recordings(200 + seed, spring, colour=COLOURS[colour])
        model = model or textbook(runs)
        state = state_of(runs, model)
        state.push(Term("spring", (1,), np.zeros(2)))
        state.refit()
        covariance, shape_errors = term_covariance(state, len(state.terms) - 1)
        assert shape_errors == {}
        assert np.all(np.linalg.eigvalsh(covariance) > 0)
        away.append((state.terms[-1].coefficients - SPRING) / np.sqrt(np.diag(covariance)))
        whole.append(np.diag(honest_covariance(state))[-2:] / np.diag(covariance))
    assert np.abs(np.mean(away, axis=0)) == pytest.approx([0, 0], abs=4 / np.sqrt(repeats))
    # slow noise may pass for what the model lacks: then errors are too large, never too small
    assert np.all(np.std(away, axis=0) < 1 + 0.45 * np.sqrt(30 / repeats))
    assert np.all(np.std(away, axis=0) > (0.55 if colour == "white" else 0.25))
    # two ways to the same, but for what reversals may do beyond noise, here nothing but chance
    assert np.all(np.mean(whole, axis=0) < 1.05)
    assert np.all(np.mean(whole, axis=0) > 0.8)


@pytest.mark.long
@pytest.mark.parametrize("colour", COLOURS)
def test_errors_of_shapes_are_their_scatter(colour):
    away, model = [], None
    for seed in range(40):
        runs = recordings(300 + seed, bump, colour=COLOURS[colour])
        model = model or textbook(recordings(300, colour=COLOURS[colour]))
        state = state_of(runs, model)
        search = Search(state, [(effect("stribeck"), (0,))], len(state.terms))
        state.push(search.best(effect("stribeck"), (0,)).term)
        search.settle()
        covariance, errors = term_covariance(state, len(state.terms) - 1)
        term = state.terms[-1]
        found = [term.coefficients[0], term.shape["vs"], term.shape["delta"]]
        claimed = [np.sqrt(covariance[0, 0]), errors["vs"], errors["delta"]]
        away.append((np.array(found) - BUMP) / claimed)
    print(colour, "mean", np.mean(away, axis=0), "scatter", np.std(away, axis=0))
    assert np.all(np.std(away, axis=0) < 1.6)
    assert np.all(np.abs(away) < 5)


def test_a_frozen_model_is_no_more_certain_than_its_own_covariance_says():
    """Frozen, coefficients hold what the model knew and what the data add: errors are smaller
    than either alone, but not zero."""
    runs = recordings(7)
    model = textbook(runs)
    frozen = state_of(runs, model, frozen=True)
    errors = np.sqrt(np.diag(full_covariance(frozen)))
    before = np.sqrt(np.diag(model.covariance))
    assert np.all(errors < 1.05 * before)
    assert np.all(errors > 0.3 * before)
