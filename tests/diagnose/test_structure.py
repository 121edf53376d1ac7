"""Maps of what no effect explains: they find what depends on motion and nothing in noise."""

from __future__ import annotations

import numpy as np
import pytest
from bare_sides import ar1
from hypothesis import given
from hypothesis import strategies as st
from two_links import NAMES, motion, recordings, state_of, textbook_torque

from pa10d.diagnose.unknown.structure import (
    Prediction,
    basis_of,
    find_structure,
    knots,
    of_all,
    questions,
    remembered,
)
from pa10d.measurement.recording import Recording


@given(st.integers(0, 1000))
def test_hats_interpolate_linearly(seed):
    rng = np.random.default_rng(seed)
    grid = np.sort(rng.uniform(-2, 2, 7))
    values, heights = rng.uniform(-3, 3, 50), rng.standard_normal(7)
    np.testing.assert_allclose(
        basis_of([values], (grid,)) @ heights, np.interp(values, grid, heights), atol=1e-9
    )


def test_products_of_hats_reproduce_a_bilinear_function():
    rng = np.random.default_rng(1)
    x, y = rng.uniform(0, 1, (2, 100))
    grid = (np.array([0.0, 0.3, 1.0]), np.array([0.0, 0.7, 0.9, 1.0]))
    heights = np.multiply.outer(grid[0] - 0.2, 2 * grid[1] + 1)
    np.testing.assert_allclose(
        basis_of([x, y], grid) @ heights.ravel(), (x - 0.2) * (2 * y + 1), atol=1e-12
    )


def test_knots_span_the_data_and_rise():
    values = np.concatenate([np.zeros(500), [3.0, -1.0]])  # most of the time at rest
    grid = knots(values, 8)
    assert np.all(np.diff(grid) > 0)
    assert (grid[0], grid[-1]) == pytest.approx((-1.0, 3.0), abs=1e-6)


def test_memory_is_the_solution_of_the_lag():
    """A step after rest: 1 - exp(-t/T)."""
    t = np.arange(2000) / 200.0
    q = np.where(t < 2.0, 0.5, 1.5)
    slow = remembered(q, 0.4, 1 / 200.0)
    np.testing.assert_allclose(slow[t < 2.0], 0.5)
    later = t >= 2.0
    expected = 0.5 + 1.0 - np.exp(-(t[later] - 2.0 + 1 / 200.0) / 0.4)
    np.testing.assert_allclose(slow[later], expected, atol=1e-9)


def test_questions_count_joints_from_one():
    asked = questions(1, 3)
    assert ("q1",) in asked
    assert ("dq2", "q1") in asked
    assert not any("0" in name.split()[0] or "4" in name for pair in asked for name in pair[:1])


HIDDEN = {
    "product of two angles": (
        0,
        {"q1", "q2"},
        lambda t, q, dq: 0.3 * np.sin(2 * q[:, 0]) * q[:, 1],
    ),
    "angle times speed": (1, {"q2", "dq2"}, lambda t, q, dq: 0.3 * np.cos(3 * q[:, 1]) * dq[:, 1]),
    "wave of the other angle": (1, {"q1"}, lambda t, q, dq: 0.15 * np.sin(5 * q[:, 0])),
    "lagging angle": (
        0,
        {"q1", "q1 2 s ago"},
        lambda t, q, dq: 1.0 * remembered(np.sin(2 * q[:, 0]), 2.0, t[1]),
    ),
}


@pytest.mark.by_default("lagging angle", "product of two angles")
@pytest.mark.parametrize("name", HIDDEN)
def test_structure_is_found_with_its_joint_and_variables(name):
    joint, variables, torque = HIDDEN[name]

    def extra(t, q, dq, ddq):
        out = np.zeros_like(q)
        out[:, joint] = torque(t, q, dq)
        return out

    found = find_structure(state_of(recordings(1, extra)))
    assert found[0].joint == joint
    assert set(found[0].variables) == variables
    assert found[0].there > 0.25
    assert found[0].p_value < 1e-3
    assert found[0].evidence.slope == pytest.approx(1.0, abs=0.3)


def test_a_share_is_of_all_the_error_also_where_the_map_knows_nothing():
    """It removes all of the error where the fit side has been; ten times as much lies beyond."""
    inside = np.arange(200) < 100
    known = np.sin(np.arange(200.0))
    residual = {0: np.where(inside, known, 10.0 * known)}
    seen = Prediction(0, ("q1",), np.where(inside, known, 0.0), inside)
    assert of_all(residual, seen) == pytest.approx(1 / 101, rel=0.05)


@pytest.mark.long
def test_a_map_says_how_large_the_torque_is():
    def extra(t, q, dq, ddq):
        return np.column_stack([np.zeros(len(t)), 0.2 * np.sin(5 * q[:, 0])])

    found = find_structure(state_of(recordings(2, extra)))[0]
    assert found.rms == pytest.approx(0.2 / np.sqrt(2), rel=0.25)
    inner = (found.grid[0] > -0.5) & (found.grid[0] < 0.5)
    expected = 0.2 * np.sin(5 * found.grid[0][inner])
    assert np.corrcoef(found.values[inner], expected)[0, 1] > 0.95


@pytest.mark.long
@pytest.mark.parametrize(
    "colour",
    [
        pytest.param(None, marks=pytest.mark.long, id="white"),
        pytest.param(lambda rng, n: ar1(rng, n, 0.95), marks=pytest.mark.long, id="coloured"),
        pytest.param(lambda rng, n: ar1(rng, n, 0.998), id="slow"),
    ],
)
def test_noise_has_no_structure(colour):
    claims = sum(len(find_structure(state_of(recordings(s, colour=colour)))) for s in range(8))
    assert claims == 0


def test_outdoes_compares_on_the_samples_that_the_map_covers():
    def extra(t, q, dq, ddq):
        return np.column_stack([0.5 * np.sin(2 * q[:, 0]) * q[:, 1], np.zeros(len(t))])

    state = state_of(recordings(3, extra))
    found = find_structure(state)[0]
    residual = state.held_residual()
    inside = found.inside
    ratio = np.mean(residual[0][inside] ** 2) / found.left
    assert ratio > 3
    assert found.outdoes(residual, 0.99 * ratio)
    assert not found.outdoes(residual, 1.01 * ratio)
    residual[0][~inside] = 1e6
    assert not found.outdoes(residual, 1.01 * ratio)


@pytest.mark.long
def test_a_plane_goes_on_where_the_fit_side_has_not_been():
    """Fitted within 0.3 of the angles at which it is judged: a curve would know little of them."""
    runs = {}
    for number, (name, span) in enumerate(zip(NAMES, (0.3, 0.3, 1.0, 1.0), strict=True)):
        t, *moves = motion(number)
        q, dq, ddq = (span * one for one in moves)
        tau = textbook_torque(q, dq, ddq)
        tau[:, 0] += 0.8 * q[:, 0] + 0.6 * q[:, 1]
        noise = 0.05 * np.random.default_rng(number).standard_normal(tau.shape)
        runs[name] = Recording(name, t, q, tau + noise)
    found = find_structure(state_of(runs))[0]
    assert (found.joint, set(found.variables)) == (0, {"q1", "q2"})
    assert found.beyond == 0.0
    assert found.share > 0.9
