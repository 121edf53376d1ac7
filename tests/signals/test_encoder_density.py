"""How noisy angles are, beside motion that is a hundred thousand times larger."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pa10d.measurement.encoder_noise import density


def moving(rate, noise, rng, seconds=60.0):
    """(N, 2) rad: slow sines as large as an arm's."""
    t = np.arange(round(seconds * rate)) / rate
    q = np.column_stack([np.sin(2.0 * np.pi * f * t) for f in rng.uniform(0.1, 0.8, 2)])
    return q + noise * rng.standard_normal(q.shape)


@settings(deadline=None, max_examples=30)
@given(
    rate=st.sampled_from([50.0, 100.0, 250.0, 1000.0]),
    noise=st.floats(1e-5, 1e-2),  # a millionth at 50 Hz: motion leaks into the lowest part
    seed=st.integers(0, 99),
)
def test_it_is_that_of_the_noise(rate, noise, seed):
    found, unlike = density(moving(rate, noise, np.random.default_rng(seed)), rate)
    assert found == pytest.approx(2.0 * noise**2 / rate, rel=0.35)
    assert np.all(unlike < 2.0)


@pytest.mark.parametrize("rate", [50.0, 100.0])
def test_motion_is_none(rate):
    """Of angles without noise as much had leaked through the window as 8 µrad of noise."""
    found, _ = density(moving(rate, 0.0, np.random.default_rng(1)), rate)
    assert np.all(found < 2.0 * 1e-7**2 / rate)


@pytest.mark.filterwarnings("error")
def test_a_joint_that_never_moves_has_none():
    q = moving(100.0, 1e-4, np.random.default_rng(1))
    q[:, 0] = 0.5
    found, unlike = density(q, 100.0)
    assert found[0] == 0.0
    assert unlike[0] == 1.0
    assert found[1] > 0.0


def test_a_jump_is_none():
    """Of a recording that was put together of two."""
    q = moving(100.0, 1e-4, np.random.default_rng(1))
    whole, _ = density(q, 100.0)
    q[1234:] += 0.3
    assert density(q, 100.0)[0] == pytest.approx(whole, rel=0.2)
