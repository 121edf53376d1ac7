"""A fit that saw no more than an effect's tail says so, whatever its standard errors are."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.diagnose.asked.one_effect import add
from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import robot_from_urdf
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording

URDF = """<robot name="pendulum"><link name="base"/>
<joint name="swing" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="50" velocity="10"/></joint>
<link name="rod"><inertial><mass value="2"/><origin xyz="0 0 -0.4"/>
<inertia ixx="0.03" iyy="0.03" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


def recording(seed: int, highest: float) -> Recording:
    """A pendulum with Stribeck friction of 0.7 N·m at 0.1 rad/s; five sines up to highest Hz."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 40.0, 1 / 200)
    w = 2 * np.pi * rng.uniform(highest / 10, highest, 5)
    a, p = rng.uniform(0.15, 0.4, 5), rng.uniform(0, 6, 5)
    s = np.outer(t, w) + p
    q, dq, ddq = np.sin(s) @ a, np.cos(s) @ (a * w), -np.sin(s) @ (a * w**2)
    friction = (0.8 + 0.7 * np.exp(-((dq / 0.1) ** 2))) * np.tanh(dq / 0.005) + 0.3 * dq
    tau = 0.35 * ddq + 7.848 * np.sin(q) + friction + rng.normal(0, 0.02, len(t))
    return Recording(t=t, q=q[:, None], tau=tau[:, None], name=f"run{seed}")


@pytest.fixture(scope="module")
def pendulum():
    return robot_from_urdf(URDF)


def test_what_only_fast_reversals_saw_is_extrapolated(pendulum):
    fast = recording(1, 0.8)
    model = identify([fast], pendulum, name="m")
    made, warnings = add(model, "stribeck", [0], [fast], name="more")
    (said,) = [w for w in warnings if "tail" in w]
    assert said.startswith("stribeck J1: only its tail was seen")
    assert "Slow constant speeds" in said
    assert str(made.term_values(len(made.terms) - 1)["Fs"]) == "not determined"


@pytest.mark.long
def test_what_was_seen_whole_is_not(pendulum):
    slow = [recording(1, 0.3), recording(2, 0.3)]
    model = identify(slow[:1], pendulum, name="m")
    made, warnings = add(model, "stribeck", [0], slow[:1], name="more")
    assert not [w for w in warnings if "tail" in w]
    assert made.term_values(len(made.terms) - 1)["Fs"].determined
    assert made.terms[-1].coefficients[0] == pytest.approx(0.7, rel=0.1)
    found = diagnose(model, slow[:1], slow[1:])
    assert [f.term.effect_id for f in found.findings] == ["stribeck"]
    assert not [w for w in found.warnings if "tail" in w]
