"""A sign that turns over as much speed as is allowed at most."""

from __future__ import annotations

import numpy as np
import pytest
from test_shift import URDF

from pa10d.dynamics import robot_from_urdf
from pa10d.identify import identify
from pa10d.measurement.recording import Recording


@pytest.mark.parametrize("share", [0.0271, 0.0285])
def test_a_sign_almost_as_wide_as_is_allowed_is_found(share):
    """The grid of speeds has a gap below the widest that is allowed; 0.010 was taken for 0.018
    rad/s and ten times the noise stayed."""
    rng = np.random.default_rng(5)
    t = np.arange(0, 60.0, 1 / 200)
    w, a, p = 2 * np.pi * rng.uniform(0.04, 0.4, 5), rng.uniform(0.2, 0.5, 5), rng.uniform(0, 6, 5)
    s = np.outer(t, w) + p
    pace = 0.604 / np.quantile(np.abs(np.cos(s) @ (a * w)), 0.99)
    t, w = t / pace, w * pace
    q, dq, ddq = np.sin(s) @ a, np.cos(s) @ (a * w), -np.sin(s) @ (a * w**2)
    rubs = 4.0 * np.tanh(dq / (share * 0.604))
    tau = 0.35 * ddq + 7.848 * np.sin(q) + rubs + 0.3 * dq + rng.normal(0, 0.02, len(t))
    run = Recording(t=t, q=q[:, None], tau=tau[:, None], name="wide")
    model = identify([run], robot_from_urdf(URDF), name="m", cutoff=8.0)
    (friction,) = [term for term in model.terms if term.effect_id == "coulomb"]
    assert friction.shape["v0"] == pytest.approx(share * 0.604, rel=0.05)
