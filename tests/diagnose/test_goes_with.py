"""A joint that only pays for what is missing on another one is told so."""

from __future__ import annotations

import numpy as np
from bare_sides import ar1
from two_links import recordings, state_of

from pa10d.diagnose.unknown.goes_with import goes_with


def shocks(t, seed):
    return 0.6 * ar1(np.random.default_rng(seed), len(t), 0.8)


def reacted(share):
    """What shakes the second joint, and so much of it the first, a sample later."""

    def extra(t, q, dq, ddq):
        shaken = shocks(t, round(1e6 * abs(q[7, 0])))
        return np.column_stack([share * np.roll(shaken, 1) * np.cos(0.3 * q[:, 1]), shaken])

    return extra


def test_what_goes_with_another_joints_rest_is_told_with_its_share():
    found = goes_with(state_of(recordings(3, reacted(0.7))), [0], [1])
    assert found[0].other == 1
    assert found[0].share > 0.8


def test_what_shakes_one_joint_alone_goes_with_nothing():
    assert goes_with(state_of(recordings(3, reacted(0.0))), [0, 1], [0, 1]) == {}


def test_slow_noise_on_both_goes_with_nothing():
    runs = recordings(20, noise=0.3, colour=lambda rng, n: ar1(rng, n, 0.999))
    assert goes_with(state_of(runs), [0, 1], [0, 1]) == {}
