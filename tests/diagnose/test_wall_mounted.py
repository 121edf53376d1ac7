"""An arm on a wall: its first axis feels gravity, so a tilt has no unknowns of the first link."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.effects.base import smooth_sign
from pa10d.effects.library.base_tilt import rotation
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording
from pa10d.profile import load_profile

RATE, SECONDS, TILT = 200.0, 25.0, 0.03


def recording(name: str, robot, gravity: np.ndarray, seed: int) -> Recording:
    rng = np.random.default_rng(seed)
    t = np.arange(round(RATE * SECONDS)) / RATE
    w = 2 * np.pi * rng.uniform(0.08, 0.5, (5, robot.n))
    a = rng.uniform(0.15, 0.4, w.shape)
    angle = w * t[:, None, None] + rng.uniform(0, 2 * np.pi, w.shape)
    q, dq = (a * np.sin(angle)).sum(axis=1), (a * w * np.cos(angle)).sum(axis=1)
    ddq = -(a * w**2 * np.sin(angle)).sum(axis=1)
    tau = inverse_dynamics(robot.with_gravity(gravity), robot.parameters, q, dq, ddq)
    tau = tau + 2.0 * np.column_stack([smooth_sign(v, 0.01) for v in dq.T]) + 3.0 * dq
    return Recording(name, t, q, tau + 0.05 * rng.standard_normal(tau.shape))


@pytest.mark.long
def test_the_tilt_of_an_arm_on_a_wall_is_named():
    upright = robot_from_profile(load_profile("pa10-sim"))
    robot = upright.with_gravity(np.array([9.81, 0.0, 0.0]))
    turned = rotation(1, TILT).T @ robot.gravity
    before = [recording(f"ref{k}", robot, robot.gravity, k) for k in range(2)]
    since = [recording(f"new{k}", robot, turned, 10 + k) for k in range(4)]
    model = identify(before, robot, name="before", cutoff=8.0)
    found = diagnose(model, since[:2], since[2:], frozen=True)
    assert [f.term.effect_id for f in found.findings] == ["base_tilt"]
    assert found.findings[0].parameters["ry"].value == pytest.approx(TILT, rel=0.05)
