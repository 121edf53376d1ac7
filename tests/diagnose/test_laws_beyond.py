"""A law that would hold but for its shape, at the end of what that may be: its quantity is told."""

from __future__ import annotations

import numpy as np
import pytest
from test_tails import URDF

from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import robot_from_urdf
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording

SHARE, SLOW = 0.234, 1.5  # of the load, rad/s: a servo's friction that a load makes at low speed


def recording(seed: int) -> Recording:
    """Six seconds of a pendulum on such a servo: too few for a map of its motion."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 6.0, 1 / 200)
    w = 2 * np.pi * rng.uniform(0.1, 0.8, 4)
    a, p = rng.uniform(0.2, 0.6, 4), rng.uniform(0, 6, 4)
    s = np.outer(t, w) + p
    q, dq, ddq = np.sin(s) @ a, np.cos(s) @ (a * w), -np.sin(s) @ (a * w**2)
    load = 0.35 * ddq + 7.848 * np.sin(q)
    level = 0.2 + SHARE * np.abs(load) * np.exp(-((np.abs(dq) / SLOW) ** 1.33))
    tau = load + level * np.tanh(dq / 0.005) + 0.9 * dq + rng.normal(0, 0.02, len(t))
    return Recording(t=t, q=q[:, None], tau=tau[:, None], name=f"run{seed}")


@pytest.mark.long  # see test_bent_shapes
def test_what_it_depends_on_is_told_though_no_shape_of_the_library_fits():
    """It was "motion does not predict it", while a fixed curve against velocity takes half."""
    runs = [recording(10 + k) for k in range(5)]
    found = diagnose(identify(runs[:3], robot_from_urdf(URDF), name="m"), runs[:3], runs[3:])
    assert "load_friction" in {f.term.effect_id for f in found.findings}
    (said,) = found.unexplained
    assert (said.joint, said.witness, said.variables) == (0, "law", ("dq1",))
    told = "depends on dq1, and no effect that was looked for explains it in a shape that it may"
    assert told in found.remaining[0].sentence
