"""A spring whose link swings within the band after every reversal, seen from sensors behind it.

The arm is this test's own: two links that hang in a plane, in closed form, friction on the motors,
torque measured between spring and link as cobots do, angles at the motors.
"""

from __future__ import annotations

from math import cos, sin, tanh

import numpy as np
import pytest

import pa10d

LENGTH, GRAVITY = 0.4, 9.81
M1, C1, I1 = 4.0, 0.22, 0.08  # kg, m, kg·m²
M2, C2, I2 = 2.5, 0.18, 0.04
A = I1 + M1 * C1**2 + I2 + M2 * (LENGTH**2 + C2**2)
B, D = M2 * LENGTH * C2, I2 + M2 * C2**2
LINKS = (A + 2 * B, D)
ROTORS, COULOMB, VISCOUS = (0.35, 0.08), (4.0, 1.2), (2.0, 0.6)
STEP, RATE, NOISE = 5e-4, 250.0, (0.03, 0.01)

LINK = """<link name="{n}"><inertial><origin xyz="0 0 -0.2"/><mass value="{m}"/>
<inertia ixx="{i}" ixy="0" ixz="0" iyy="{i}" iyz="0" izz="0.01"/></inertial></link>"""
JOINT = """<joint name="{n}" type="revolute"><parent link="{p}"/><child link="{c}"/>
<origin xyz="0 0 {z}"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="10" effort="300"/></joint>"""


def urdf(size: float) -> str:
    """size: kg of what weighs a kilogram."""
    return (
        '<robot name="two"><link name="base"/>'
        + LINK.format(n="upper", m=4 * size, i=0.08 * size)
        + LINK.format(n="lower", m=2.5 * size, i=0.04 * size)
        + JOINT.format(n="a", p="base", c="upper", z=0)
        + JOINT.format(n="b", p="upper", c="lower", z=-LENGTH)
        + "</robot>"
    )


def weight(q1: float, q2: float) -> tuple[float, float]:
    """N·m that hold the links."""
    outer = M2 * GRAVITY * C2 * sin(q1 + q2)
    return (M1 * C1 + M2 * LENGTH) * GRAVITY * sin(q1) + outer, outer


def reference(rng: np.random.Generator, t: np.ndarray, reach: float) -> tuple[list, list]:
    """Angle and speed of five sines, from rest."""
    omega = 2 * np.pi * 0.09 * np.arange(1, 6) * rng.uniform(0.95, 1.05, 5)
    wave = np.sin(np.outer(t, omega) + rng.uniform(0, 6.28, 5)) @ (rng.normal(size=5) / range(1, 6))
    q = np.clip(t / 2, 0, 1) ** 2 * wave
    q *= reach / np.abs(q).max()
    return q.tolist(), np.gradient(q, STEP).tolist()


def recording(
    seconds: float, seed: int, joint: int, hertz: float, zeta: float = 0.06
) -> tuple[np.ndarray, float]:
    """(K, 5) time, angles of the motors, torque behind the springs; and the soft joint's K. The
    other joint's spring swings at 60 Hz. zeta: damping ratio of the soft one."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds / STEP)) * STEP
    (r1, d1), (r2, d2) = reference(rng, t, 1.0), reference(rng, t, 1.2)
    modes = [hertz if j == joint else 60.0 for j in (0, 1)]
    k1, k2 = ((2 * np.pi * f) ** 2 * i for f, i in zip(modes, LINKS, strict=True))
    z1, z2 = (zeta if j == joint else 0.2 for j in (0, 1))
    c1, c2 = 2 * z1 * (k1 * LINKS[0]) ** 0.5, 2 * z2 * (k2 * LINKS[1]) ** 0.5
    loop = [(i + ia) * (10 * np.pi) ** 2 for i, ia in zip(LINKS, ROTORS, strict=True)]
    brake = [1.6 * (i + ia) * 10 * np.pi for i, ia in zip(LINKS, ROTORS, strict=True)]
    p1, p2, u1, u2, v1, v2 = r1[0], r2[0], 0.0, 0.0, 0.0, 0.0
    g1, g2 = weight(p1, p2)
    q1, q2 = p1 - g1 / k1, p2 - g2 / k2
    every = round(1 / RATE / STEP)
    out = np.empty((len(t) // every, 4))
    for i in range(len(t)):
        h1, h2 = weight(p1, p2)
        t1 = h1 + loop[0] * (r1[i] - p1) + brake[0] * (d1[i] - u1)
        t2 = h2 + loop[1] * (r2[i] - p2) + brake[1] * (d2[i] - u2)
        s1 = k1 * (p1 - q1) + c1 * (u1 - v1)
        s2 = k2 * (p2 - q2) + c2 * (u2 - v2)
        u1 += STEP * (t1 - COULOMB[0] * tanh(u1 / 1e-3) - VISCOUS[0] * u1 - s1) / ROTORS[0]
        u2 += STEP * (t2 - COULOMB[1] * tanh(u2 / 1e-3) - VISCOUS[1] * u2 - s2) / ROTORS[1]
        p1, p2 = p1 + STEP * u1, p2 + STEP * u2
        c, s = B * cos(q2), B * sin(q2)
        g1, g2 = weight(q1, q2)
        e1, e2 = s1 - g1 + s * (2 * v1 * v2 + v2 * v2), s2 - g2 - s * v1 * v1
        m11, m12 = A + 2 * c, D + c
        scale = STEP / (m11 * D - m12 * m12)
        v1, v2 = v1 + scale * (D * e1 - m12 * e2), v2 + scale * (m11 * e2 - m12 * e1)
        q1, q2 = q1 + STEP * v1, q2 + STEP * v2
        if i % every == every - 1:
            out[i // every] = p1, p2, s1, s2
    out[:, :2] = np.round(out[:, :2] / 1e-5) * 1e-5
    out[:, 2:] += rng.standard_normal((len(out), 2)) * NOISE
    return np.column_stack([np.arange(len(out)) / RATE, out]), (k1, k2)[joint]


@pytest.mark.parametrize(
    ("joint", "size"),
    [
        pytest.param(0, 1.0, marks=pytest.mark.long),
        pytest.param(1, 1.0, marks=pytest.mark.long),
        pytest.param(1, 1e-3, marks=pytest.mark.long),
    ],
)
def test_a_spring_that_swings_after_reversals_is_found(tmp_path, joint, size):
    """Of an arm of 6 kg, and of one of 6 g: nothing but the unit of mass differs."""
    (tmp_path / "two.urdf").write_text(urdf(size))
    robot = pa10d.load_robot(tmp_path / "two.urdf")
    runs = []
    for seconds, seed in ((16.0, 1), (10.0, 2)):
        rows, stiffness = recording(seconds, seed, joint, 10.0)
        rows[:, 3:] *= size
        path = tmp_path / f"run{seed}.csv"
        np.savetxt(path, rows, delimiter=",", header="time,q1,q2,tau1,tau2", comments="")
        runs.append(pa10d.load_run(path, robot))
    found = pa10d.diagnose(pa10d.identify(robot, runs[:1]), runs[:1], runs[1:])
    assert [(one.effect, one.joints) for one in found.findings] == [
        ("joint_elasticity", (joint + 1,))
    ]
    spring = found.findings[0].parameters["K"]
    assert abs(spring.value - stiffness * size) < 2 * spring.std_error
    assert spring.std_error < 0.1 * spring.value
    assert np.all(found.findings[0].rms_after < 0.3 * found.rms)
