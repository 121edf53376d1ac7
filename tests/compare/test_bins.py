"""Bins over any quantity: every one is visited, also where the quantity takes few values."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as some

from pa10d.compare.curves import Curve
from pa10d.compare.quantities import Quantity
from pa10d.compare.samples import JointSamples, bins
from pa10d.compare.search import PlaceSearch

RATE = 50.0  # Hz
WARMTH = Quantity("temperature", 1, "°C")
ANGLE = Quantity("q", 1, "rad")


@settings(deadline=None, max_examples=200)
@given(
    values=some.lists(some.integers(-3, 12), min_size=4, max_size=12, unique=True),
    weights=some.lists(some.integers(1, 400), min_size=12, max_size=12),
)
def test_every_bin_holds_samples(values, weights):
    x = np.repeat(np.array(values, dtype=float), weights[: len(values)])
    table = bins(WARMTH, x, np.ones(len(x), dtype=bool))
    if table is None:
        return
    assert table.count.min() >= 1
    assert table.count.sum() == len(x)
    assert (np.diff(table.edges) > 0).all()
    assert (table.edges[0], table.edges[-1]) == (x.min(), x.max())
    middle = np.searchsorted(table.edges[1:-1], x, side="right")
    np.testing.assert_array_equal(table.sums(x), np.bincount(middle, weights=x))


def test_a_temperature_in_whole_degrees_hides_no_other_place():
    """It has quantiles between its degrees; a bin there made every figure nan."""
    rng = np.random.default_rng(3)
    t = np.arange(4000) / RATE
    q = np.sin(0.7 * t) + 0.3 * np.sin(1.9 * t)
    degrees = np.repeat([30.0, 31.0, 33.0, 34.0, 37.0, 38.0], [1000, 500, 500, 500, 500, 1000])
    error = 2.0 * q + rng.normal(size=len(t))
    samples = JointSamples(1, [(error, np.ones(len(t), bool))], {ANGLE: q, WARMTH: degrees}, RATE)
    found = [place for place, _ in PlaceSearch(samples, 0.01, 0).run()]
    assert any(isinstance(one, Curve) and one.quantity == ANGLE for one in found)
