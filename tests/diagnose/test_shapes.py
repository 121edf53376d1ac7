"""The search for a shape: inside its bounds, never worse than where it began."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pa10d.diagnose.regression.shapes import approach, refine
from pa10d.effects.base import ShapeParameter


def kind(*shapes: ShapeParameter) -> SimpleNamespace:
    return SimpleNamespace(id="any", shapes=shapes)


SPEED = ShapeParameter("vs", "rad/s", 1e-3, 1.0, "log")
POWER = ShapeParameter("delta", "1", 0.5, 2.0)
SIDE = ShapeParameter("side", "1", -1.0, 1.0, "choice")


@given(st.floats(-0.7, 0.7))
@settings(max_examples=30, deadline=None)
def test_one_parameter_is_found_on_its_own_scale(octaves):
    best = 0.05 * np.exp(octaves)
    found = refine(kind(SPEED), {"vs": 0.05}, lambda s: -(np.log(s["vs"] / best) ** 2))
    assert found["vs"] == pytest.approx(best, rel=0.02)


@given(st.floats(-0.5, 0.5), st.floats(-0.3, 0.3))
@settings(max_examples=30, deadline=None)
def test_two_parameters_and_a_choice(octaves, offset):
    vs, delta = 0.05 * np.exp(octaves), 1.2 + offset

    def gain(s):
        assert s["side"] == -1.0  # choices stay as they are
        return -(np.log(s["vs"] / vs) ** 2) - (s["delta"] - delta) ** 2

    start = {"vs": 0.05, "delta": 1.2, "side": -1.0}
    found = refine(kind(SPEED, POWER, SIDE), start, gain)
    assert gain(found) > -0.01
    assert gain(found) >= gain(start)


def test_the_search_stays_within_the_bounds():
    found = refine(kind(SPEED, POWER), {"vs": 0.9, "delta": 1.9}, lambda s: s["vs"] + s["delta"])
    assert SPEED.lower <= found["vs"] <= SPEED.upper
    assert POWER.lower <= found["delta"] <= POWER.upper
    assert found["vs"] > 0.97


def test_a_start_at_the_top_of_a_rough_hill_is_kept():
    rough = np.random.default_rng(0)
    start = {"vs": 0.05}
    found = refine(kind(SPEED), start, lambda s: 1.0 if s == start else -rough.random())
    assert found == start


def test_nothing_to_search():
    assert refine(kind(SIDE), {"side": 1.0}, lambda s: 0.0) == {"side": 1.0}
    assert refine(kind(), {}, lambda s: 0.0) == {}


def bump(x: np.ndarray, shape) -> np.ndarray:
    return np.exp(-((x / shape["vs"]) ** shape["delta"]))


@given(st.floats(-0.4, 0.4), st.floats(-0.3, 0.3))
@settings(max_examples=30, deadline=None)
def test_gauss_newton_ends_at_the_best_shape_nearby(octaves, offset):
    x = np.linspace(0.01, 0.5, 200)
    true = {"vs": 0.1 * np.exp(octaves), "delta": 1.2 + offset}
    start = {"vs": 0.1, "delta": 1.2}

    def gain(s):
        return -1e4 * float(np.sum((bump(x, true) - bump(x, s)) ** 2))

    def move(s):
        slopes = []
        for name in s:
            step = 1e-4 * s[name]
            up, down = ({**s, name: s[name] + d} for d in (step, -step))
            slopes.append((bump(x, up) - bump(x, down)) / (2 * step))
        return np.linalg.lstsq(np.column_stack(slopes), bump(x, true) - bump(x, s), rcond=None)[0]

    found = approach(kind(SPEED, POWER), start, gain, move)
    assert gain(found) > -1.0, "within noise of the best"
    assert found["vs"] == pytest.approx(true["vs"], rel=0.02)


def test_a_misleading_direction_changes_nothing():
    start = {"vs": 0.05, "delta": 1.0}
    found = approach(
        kind(SPEED, POWER), start, lambda s: -abs(np.log(s["vs"] / 0.05)), lambda s: np.ones(2)
    )
    assert found == start
