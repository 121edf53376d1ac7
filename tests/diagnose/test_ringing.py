"""What motion sets swinging, and what swings on, is no noise though no map knows of it."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.signal
from two_links import CUTOFF, motion, robot, textbook_torque

from pa10d.diagnose.procedure import diagnose
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording


def sloshing(name, seed, size, hertz):
    """A liquid of the inertia ``size``, kg·m², about joint 2, held by a spring of the tank's."""
    rng = np.random.default_rng(seed)
    t, q, dq, ddq = motion(seed)
    w = 2 * np.pi * hertz
    tank = scipy.signal.TransferFunction([2 * 0.02 * w, w**2], [1.0, 2 * 0.02 * w, w**2])
    tau = textbook_torque(q, dq, ddq) + 0.03 * rng.standard_normal(q.shape)
    tau[:, 1] += size * scipy.signal.lsim(tank, ddq[:, 1], t)[1]
    return Recording(name, t, q, tau)


def told(size, hertz):
    runs = [sloshing(name, seed, size, hertz) for seed, name in enumerate("abc", 1)]
    model = identify(runs[:2], robot(), name="m0", cutoff=CUTOFF)
    return diagnose(model, runs[:2], runs[2:])


@pytest.mark.long
def test_a_liquid_is_told_by_its_frequency():
    found = told(0.1, 1.1)
    assert found.verdict == "unknown"
    only = next(one for one in found.unexplained if one.joint == 1)
    assert only.witness == "ring"
    assert only.hertz == pytest.approx(1.1, rel=0.06)
    assert only.share > 0.6
    assert "swings on by itself" in found.remaining[1].sentence


@pytest.mark.long
def test_nothing_rings_in_a_clean_arm():
    found = told(0.0, 1.1)
    assert found.verdict == "none"
    assert not found.unexplained
