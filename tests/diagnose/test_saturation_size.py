"""A saturation is as large as it is said to be, where noise hides the last steps to it, too."""

from __future__ import annotations

import numpy as np
import pytest
from two_links import robot

from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import inverse_dynamics
from pa10d.identify import identify
from pa10d.measurement.recording import Recording

C3 = 2.2e-4  # 1/(N·m)²: much of the slope is gone at the largest torques


def run(seed: int) -> Recording:
    """30 s whose first joint reads x where x - C3·x³ is there, with noise of a twentieth of it."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 30.0, 1 / 200)
    w = 2 * np.pi * 0.15 * (1.0 + 0.1 * seed) * np.arange(1, 5)
    a, p = rng.uniform(0.15, 0.45, (2, 4)) / np.sqrt(np.arange(1, 5)), rng.uniform(0, 6, (2, 4))
    s = np.outer(t, w)[:, None] + p
    q, dq, ddq = (np.sin(s) * a, np.cos(s) * a * w, -np.sin(s) * a * w**2)
    q, dq, ddq = (x.sum(axis=2) for x in (q, dq, ddq))
    tau = inverse_dynamics(robot(), robot().parameters, q, dq, ddq)
    tau += np.array([2.0, 0.8]) * np.tanh(dq / 0.01) + np.array([1.0, 0.4]) * dq
    true, read = tau[:, 0], tau[:, 0].copy()
    for _ in range(60):  # Newton's method
        read -= (read - C3 * read**3 - true) / (1 - 3 * C3 * read**2)
    assert np.max(np.abs(read)) < 0.9 / np.sqrt(3 * C3)
    tau[:, 0] = read
    tau += rng.normal(size=tau.shape) * 0.05 * np.abs(tau).max(axis=0)
    return Recording(t=t, q=q, tau=tau, name=f"run{seed}")


@pytest.mark.long
def test_it_is_found_at_its_size():
    fit, valid = [run(0), run(1)], [run(2)]
    model = identify(fit, robot(), name="m")
    found = diagnose(model, fit=fit, validate=valid).findings[0]
    assert (found.term.effect_id, found.term.joints) == ("torque_saturation", (0,))
    c3 = found.parameters["c3"]
    assert c3.value == pytest.approx(C3, rel=0.04)
