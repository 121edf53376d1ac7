"""The smoothed sign, averaged over each sample interval, against numerical integration."""

import numpy as np
import pytest
from scipy.integrate import quad

from pa10d.effects import smooth_sign

DT = 0.002


@pytest.mark.parametrize("v0", [5e-4, 0.01, 0.2])
@pytest.mark.parametrize("acceleration", [0.05, 3.0, 400.0])
def test_mean_over_the_interval(v0, acceleration):
    """A reversal with constant acceleration, so that velocity is linear in every interval."""
    t = (np.arange(41) - 20.3) * DT
    found = smooth_sign(acceleration * t, v0)
    for k in range(1, 40):
        ends = acceleration * (t[k] + 0.5 * DT * np.array([-1.0, 1.0]))
        mean = quad(lambda v: np.tanh(v / v0), *ends, points=[0.0], limit=200)[0] / np.diff(ends)
        assert found[k] == pytest.approx(float(mean[0]), abs=1e-7)


def test_a_reversal_within_one_sample_is_not_lost():
    """The area under the sign tells when the joint turned, to a small part of a sample."""
    for early in (0.1, 0.5, 0.8):
        t = (np.arange(200) - 100 + early) * DT
        area = float(np.sum(smooth_sign(5.0 * t, 1e-4)) * DT)
        # intervals reach half a sample beyond the first and the last time
        exact = t[-1] + 0.5 * DT + (t[0] - 0.5 * DT)
        assert area == pytest.approx(exact, abs=0.02 * DT)


def test_constant_speed_standstill_and_one_sample():
    assert smooth_sign(np.full(5, 0.3), 0.01) == pytest.approx(1.0)
    assert smooth_sign(np.full(5, -0.003), 0.01) == pytest.approx(np.tanh(-0.3))
    assert not smooth_sign(np.zeros(5), 1e-4).any()
    assert smooth_sign(np.array([0.02]), 0.01) == pytest.approx(np.tanh(2.0))


def test_huge_ratios_do_not_overflow():
    found = smooth_sign(np.linspace(-50.0, 50.0, 7), 1e-4)
    assert np.isfinite(found).all()
    assert np.max(np.abs(found)) <= 1.0 + 1e-12
