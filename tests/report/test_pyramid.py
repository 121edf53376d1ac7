"""Long signals at a glance: no peak is lost, and every stretch lies where it was measured."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.figures.coarse import coarser
from pa10d.figures.pyramid import BLOCK, Pyramid


@pytest.mark.parametrize("length", [3, 999, 100_000, 1_000_003])
@pytest.mark.parametrize("points", [200, 2000])
def test_a_single_peak_is_seen_where_it_is(length, points):
    signal = np.zeros(length)
    peak = int(0.62 * length)
    signal[peak] = 7.0
    values, begin, step = Pyramid(signal).stretch(0, length, points)
    assert values.max() == 7.0
    assert len(values) <= points + 2
    found = begin + step * int(np.argmax(values))
    assert abs(found - peak) <= 2 * step


def test_a_zoom_has_every_sample():
    signal = np.sin(np.arange(1e6) / 100)
    values, begin, step = Pyramid(signal).stretch(500_000, 501_000, 2000)
    assert (begin, step) == (500_000, 1.0)
    assert np.allclose(values, signal[500_000:501_000], atol=1e-6)


def test_a_stretch_of_blocks_lies_where_it_was_measured():
    ramp = np.arange(4_000_000, dtype=float)
    values, begin, step = Pyramid(ramp).stretch(1_000_000, 3_000_000, 1000)
    at = begin + step * np.arange(len(values))
    assert abs(begin - 1_000_000) <= BLOCK
    assert np.abs(values - at).max() <= 2 * step
    assert values[-1] >= 3_000_000 - 2


def test_a_coarser_mesh_keeps_its_size():
    side = 300
    x, y = np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 2, side), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.sin(3 * x).ravel()])
    k = np.arange(side * side).reshape(side, side)[:-1, :-1].ravel()
    faces = np.vstack(
        [np.column_stack([k, k + 1, k + side]), np.column_stack([k + 1, k + side, k + side + 1])]
    )
    less, kept = coarser(points, faces.astype(np.uint32), 20_000)
    assert 2_000 < len(kept) <= 20_000
    assert kept.max() < len(less)
    assert np.allclose(less.min(axis=0), points.min(axis=0), atol=0.02)
    assert np.allclose(less.max(axis=0), points.max(axis=0), atol=0.02)
    same, all_of = coarser(points, faces.astype(np.uint32), 10**6)
    assert same is points
    assert len(all_of) == len(faces)
