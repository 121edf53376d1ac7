"""The smooth map: its splines, its penalty, its edges, and that nobody takes it for an effect."""

from __future__ import annotations

import numpy as np
import pytest
from effect_motions import arm_context
from hypothesis import given
from hypothesis import strategies as st

from pa10d.common.errors import UserError
from pa10d.diagnose.search.suspects import suspects
from pa10d.effects import all_effects, effect
from pa10d.effects.smooth_map import DEGREE, SEGMENTS, SMOOTHING, smooth_map, splines
from pa10d.effects.variables import at_joint, parsed, remembered, values_of


def bell(x: np.ndarray, width: float) -> np.ndarray:
    """The cardinal cubic B-spline, centred, as a convolution of four boxes worked out by hand."""
    u = np.abs(x) / width
    inner = 2.0 / 3.0 - u**2 + 0.5 * u**3
    outer = (2.0 - u) ** 3 / 6.0
    return np.where(u < 1.0, inner, np.where(u < 2.0, outer, 0.0))


def test_columns_are_cubic_b_splines():
    low, high, segments = -0.7, 1.3, 8
    x = np.linspace(low, high, 501)
    found = splines(x, low, high, segments)
    width = (high - low) / segments
    assert found.shape == (501, segments + DEGREE)
    for k in range(segments + DEGREE):
        centre = low + (k - 1) * width
        np.testing.assert_allclose(found[:, k], bell(x - centre, width), atol=1e-12)


@given(st.lists(st.floats(-50.0, 50.0), min_size=1, max_size=30))
def test_they_add_up_to_one_everywhere(values):
    found = splines(np.array(values), -1.0, 2.0, 24)
    np.testing.assert_allclose(found.sum(axis=1), 1.0, atol=1e-12)
    assert np.all(found >= 0.0)


def test_beyond_the_range_the_map_stays_what_it_is_at_the_edge():
    rng = np.random.default_rng(0)
    heights = rng.normal(size=24 + DEGREE)
    edge = splines(np.array([-1.0, 2.0]), -1.0, 2.0, 24) @ heights
    far = splines(np.array([-9.0, -1.1, 2.1, 1e6]), -1.0, 2.0, 24) @ heights
    np.testing.assert_allclose(far, edge[[0, 0, 1, 1]], atol=1e-12)


def shape_of(kind, context):
    return dict(kind.starts(context, [1])[0])


def test_a_map_of_two_is_the_product_of_two_of_one():
    context = arm_context(seconds=1.0)
    kind = smooth_map(("q2", "dq4"))
    shape = shape_of(kind, context)
    found = kind.columns(context, [1], shape)
    one = splines(context.q[:, 1], shape["q2 from"], shape["q2 to"], SEGMENTS[2])
    slow = 0.1 * max(abs(shape["dq4 from"]), abs(shape["dq4 to"]))
    ends = (np.arcsinh(shape[f"dq4 {end}"] / slow) for end in ("from", "to"))
    other = splines(np.arcsinh(context.dq[:, 3] / slow), *ends, SEGMENTS[2])
    np.testing.assert_allclose(
        found, np.einsum("ti,tj->tij", one, other).reshape(len(found), -1), atol=1e-12
    )
    np.testing.assert_allclose(found.sum(axis=1), 1.0, atol=1e-12)
    assert found.shape[1] == len(kind.coefficients)


@pytest.mark.parametrize("over", [("q2",), ("q2", "dq4")])
def test_the_penalty_is_the_roughness_of_the_coefficients(over):
    kind = smooth_map(over)
    root = kind.penalty({SMOOTHING: 4.0})
    side = SEGMENTS[len(over)] + DEGREE
    heights = np.random.default_rng(1).normal(size=(side,) * len(over))
    rough = [
        sum(np.sum(np.diff(heights, order, axis=a) ** 2) for a in range(len(over)))
        for order in (2, 1, 0)
    ]
    expected = 4.0 * (rough[0] + 1e-3 * rough[1] + 1e-5 * rough[2])
    assert np.sum((root @ heights.ravel()) ** 2) == pytest.approx(expected)
    assert np.linalg.matrix_rank(root) == side ** len(over)


def test_it_knows_where_it_has_not_been():
    context = arm_context(seconds=4.0)
    kind = smooth_map(("q2",))
    q = context.q[:, 1]
    low, high = np.quantile(q, [0.2, 0.9])
    beyond = kind.outside(context, {"q2 from": low, "q2 to": high, SMOOTHING: 1.0})
    assert beyond.mean() == pytest.approx(0.3, abs=0.01)
    assert np.array_equal(beyond, (q < low) | (q > high))
    assert effect("spring").outside(context, {}) is None


def test_quantities_are_those_of_the_motion():
    context = arm_context(seconds=2.0)
    assert np.array_equal(values_of(context, "q3"), context.q[:, 2])
    assert np.array_equal(values_of(context, "dq1"), context.dq[:, 0])
    assert np.array_equal(values_of(context, "load2"), context.load[:, 1])
    assert np.array_equal(values_of(context, "t"), context.t)
    slow = remembered(context.q[:, 3], 0.4, context.dt)
    assert np.array_equal(values_of(context, "q4 0.4 s ago"), slow)
    smooth = values_of(context, "ddq2")
    assert np.corrcoef(smooth, context.ddq[:, 1])[0, 1] > 0.9
    with pytest.raises(UserError, match="no temperature"):
        values_of(context, "temperature1")


def test_names_are_completed_and_checked():
    assert at_joint("q", 3, 7) == "q4"
    assert at_joint("dq2", 3, 7) == "dq2"
    assert at_joint("q 0.40 s ago", 3, 7) == "q4 0.4 s ago"
    assert at_joint("t", 3, 7) == "t"
    assert parsed("q12 2 s ago") == ("q", 11, 2.0)
    with pytest.raises(UserError, match="expected joint 1 to 7"):
        at_joint("q8", 3, 7)
    for wrong in ("", "q0", "wind", "dq4 0.4 s ago", "q-1", "x4"):
        with pytest.raises(UserError, match="expected q, dq, ddq"):
            parsed(wrong)


def test_nobody_looks_for_it():
    assert "smooth_map" not in all_effects()
    for frozen in (True, False):
        assert "smooth_map" not in {kind.id for kind, _ in suspects(frozen, 7)}
    assert effect("smooth_map").question == "chosen"


def test_a_map_over_loads_follows_the_model():
    assert smooth_map(("load2",)).uses_model
    assert not smooth_map(("q2", "t")).uses_model
