"""Springs, stops, ripple, loads and oddities: what the torque shows along a measured motion.

The rest that Newton-Euler, rotor, Coulomb and viscous friction leave over (by Pinocchio, on the
true motion) must be the effect's own torque.
"""

import numpy as np
import pytest
from plant_robots import (
    G,
    bare,
    driven,
    joint,
    link,
    pendulum,
    profile_of,
    seven_axes,
    sliding,
    turntable,
    unexplained,
)

from backends.virtual.datasets import motion_of, reach_of, run_motion
from backends.virtual.plant import build

DT = 0.002

CASES = {
    "torque_ripple": (
        {"joint": 2, "N": 50, "sin": 1.5, "cos": 0.8},
        lambda m: {1: 1.5 * np.sin(50 * m["q"][:, 1]) + 0.8 * np.cos(50 * m["q"][:, 1])},
    ),
    "spring": (
        {"joint": 4, "k": 3.0, "q0": 0.2},
        lambda m: {3: 3.0 * (m["q"][:, 3] - 0.2)},
    ),
    "contact": (
        {"joint": 1, "k": 60.0, "qs": 0.1},
        lambda m: {0: 60.0 * np.maximum(m["q"][:, 0] - 0.1, 0)},
    ),
    "load_friction": (
        {"joint": 2, "mu": 0.08},
        lambda m: {1: 0.08 * np.abs(m["load"][:, 1]) * np.sign(m["dq"][:, 1])},
    ),
    "coupling_inertia": (
        {"joints": [1, 2], "Ia": 0.4},
        lambda m: {0: 0.4 * m["ddq"][:, 1], 1: 0.4 * m["ddq"][:, 0]},
    ),
    "coupling_friction": (
        {"joints": [5, 6], "F": 0.3, "Fv": 0.1, "sign": -1},
        lambda m: {4: belt(m, 1.0), 5: belt(m, -1.0)},
    ),
    "cable_drag": (
        {"joints": [2, 4], "amplitude": 5.0, "phase": 0.4},
        lambda m: {1: 5.0 * np.sin(m["q"][:, 1]) * np.sin(m["q"][:, 3] + 0.4)},
    ),
    "windage": (
        {"joint": 5, "drag": 0.08},
        lambda m: {4: 0.08 * m["q"][:, 4] * np.abs(m["dq"][:, 4]) * m["dq"][:, 4]},
    ),
    "magnet_detent": (
        {"joint": 3, "pull": 2.0, "centre": 0.1, "width": 0.2},
        lambda m: {2: detent(m["q"][:, 2])},
    ),
    "gyroscope": (
        {"joints": [2, 5], "amplitude": 3.0},
        lambda m: {1: 3.0 * m["dq"][:, 1] * m["dq"][:, 4]},
    ),
}


def belt(m, share):
    slip = m["dq"][:, 4] - m["dq"][:, 5]
    return share * (0.3 * np.sign(slip) + 0.1 * slip)


def detent(q):
    x = (q - 0.1) / 0.2
    return 2.0 * x * np.exp(0.5 - x**2 / 2)


@pytest.mark.parametrize("name", CASES)
def test_rest_is_the_effect(name):
    entry, expected = CASES[name]
    profile = seven_axes()
    plant = build(
        profile,
        effects=[{"effect": name, **entry}],
        noise="none",
        resolution=0.0,
        dynamics={"spread": 0.2, "seed": 3},
    )
    motion = motion_of("train_a", np.random.default_rng(3), reach_of(profile), 10.0)
    run, _ = run_motion(plant, profile, motion, 10.0)
    found = unexplained(plant, profile.urdf, run.q, run.tau, DT)
    steady = sliding(found["dq"], 0.02, 12)
    if name == "coupling_friction":
        steady &= sliding(found["dq"][:, 4:5] - found["dq"][:, 5:6], 0.02, 12)
    effect = expected(found)
    for j in range(7):
        rest = found["rest"][steady, j]
        wanted = effect[j][steady] if j in effect else np.zeros(len(rest))
        scale = np.sqrt(np.mean(found["torque"][steady, j] ** 2))
        error = np.sqrt(np.mean((rest - wanted) ** 2))
        assert error < 2e-4 * scale
        if j in effect:
            assert error < 0.02 * np.std(wanted)


def test_ripple_turns_with_the_joint_not_with_time(tmp_path):
    """At two speeds the same number of cycles per revolution."""
    effect = {"effect": "torque_ripple", "joint": 1, "N": 30, "sin": 0.6, "cos": -0.8}
    plant = bare(turntable(tmp_path, inertia=3.0), [effect], rotor_inertia=0.5)
    for speed in (0.3, 0.6):
        t = np.arange(0, 2 * np.pi / speed, DT)
        q = (speed * t)[:, None]
        plant.reset(np.zeros(1))
        plant.state.v[0] = speed
        angle, torque = driven(plant, q, np.full_like(q, speed), DT, bandwidth=2.0)
        grid = np.linspace(0.5, 0.5 + 5 * 2 * np.pi / 30, 1000, endpoint=False)
        lines = np.abs(np.fft.rfft(np.interp(grid, angle[:, 0], torque[:, 0]))) / 500
        assert np.argmax(lines[1:]) + 1 == 5
        assert lines[5] == pytest.approx(1.0, rel=0.1)


def settled(plant, pose, torque, steps=4000):
    plant.reset(np.array([pose]))
    for _ in range(steps):
        plant.step(np.array([torque]), DT)
    return plant.measure()[0][0]


def test_a_stop_gives_way_by_force_over_stiffness(tmp_path):
    for side in (1.0, -1.0):
        effect = {"effect": "contact", "joint": 1, "k": 300.0, "qs": 0.5 * side, "side": side}
        plant = bare(turntable(tmp_path), [effect | {"damping": 20.0}], viscous=5.0)
        assert settled(plant, 0.0, 6.0 * side) == pytest.approx(
            side * (0.5 + 6.0 / 300.0), rel=1e-6
        )


def test_a_stop_pushes_and_never_pulls(tmp_path):
    effect = {"effect": "contact", "joint": 1, "k": 300.0, "qs": 0.5, "damping": 200.0}
    plant = bare(turntable(tmp_path), [effect])
    plant.state.q[0], plant.state.v[0] = 0.499, 1.0
    for _ in range(500):
        before = plant.state.v[0]
        plant.step(np.zeros(1), DT)
        assert plant.state.v[0] <= before + 1e-12
    assert -1.0 < plant.state.v[0] < 0.0


def test_payload_adds_its_moment_to_the_holding_torque(tmp_path):
    load = {"effect": "payload", "mass": 2.0, "cx": 0.1, "cz": 0.6}
    plant = bare(pendulum(tmp_path, 4.0, 0.5), [load], rotor_inertia=0.5, coulomb=50.0)
    plant.reset(np.array([0.7]))
    plant.step(np.zeros(1), DT)
    horizontal = 4.0 * 0.5 * np.sin(0.7) + 2.0 * (0.6 * np.sin(0.7) + 0.1 * np.cos(0.7))
    assert plant.state.rubbing[0] == pytest.approx(G * horizontal, rel=1e-6)


def test_leaning_base_loads_a_vertical_axis(tmp_path):
    """Turned about y by φ, an arm along x is pulled sideways: only sin φ matters."""
    profile = profile_of(
        tmp_path, link("l0", 3.0, "0.4 0 0", (0.1, 0.1, 0.1)), joint("j0", "base", "l0", "0 0 1")
    )
    plant = bare(profile, [{"effect": "base_tilt", "y": 0.05}], coulomb=50.0)
    for angle in (0.0, 1.1):
        plant.reset(np.array([angle]))
        plant.step(np.zeros(1), DT)
        # base x axis points down by sin φ: gravity along it is +g sin φ
        expected = 3.0 * G * np.sin(0.05) * -0.4 * np.sin(angle)
        assert plant.state.rubbing[0] == pytest.approx(expected, abs=1e-9)


def test_creep_forgets(tmp_path):
    """A step in angle pulls back by k·Δq, then lets go with its time constant."""
    plant = bare(turntable(tmp_path), [{"effect": "creep", "joint": 1, "k": 50.0, "T": 0.5}])
    t = np.arange(0, 3, DT)
    q = np.minimum(0.4 * t / 0.1, 0.4)[:, None]
    dq = np.where(t < 0.1, 4.0, 0.0)[:, None]
    _, torque = driven(plant, q, dq, DT, bandwidth=3.0)
    at = {s: torque[round(s / DT) : round(s / DT) + 20, 0].mean() for s in (0.6, 1.1, 1.6)}
    assert at[1.1] / at[0.6] == pytest.approx(np.exp(-1.0), rel=0.05)
    assert at[1.6] / at[1.1] == pytest.approx(np.exp(-1.0), rel=0.05)
    # spring wound over 0.1 s: k · 4 rad/s · T (1 - exp(-0.1/T)), then decaying
    wound = 50.0 * 4.0 * 0.5 * (1 - np.exp(-0.2))
    assert at[0.6] == pytest.approx(wound * np.exp(-(0.6 - 0.1 + 0.019) / 0.5), rel=0.05)
