"""Friction beyond the textbook, on joints slow or steady enough to be worked out by hand."""

import numpy as np
import pytest
from plant_robots import G, bare, driven, pendulum, turntable
from scipy.integrate import solve_ivp
from scipy.optimize import curve_fit

from backends.virtual.plant.servo import servo_for

DT = 0.002


def torque_at(plant, speed, joint=0, seconds=2.0, start=0.0):
    """Mean torque of one joint in steady sliding at a constant speed, the others held."""
    t = np.arange(round(seconds / DT)) * DT
    q, dq = np.zeros((len(t), plant.n)), np.zeros((len(t), plant.n))
    q[:, joint], dq[:, joint] = start + speed * t, speed
    plant.reset(q[0])
    plant.state.v[plant.physics.transmission.rotor[joint]] = speed
    plant.state.v[joint] = speed
    _, torque = driven_on(plant, q, dq)
    return torque[len(t) // 2 :].mean(axis=0)


def driven_on(plant, q, dq):
    """Servo a plant that already moves."""
    soft = plant.physics.transmission.rotor >= plant.n
    servo = servo_for(plant.physics.arm, plant.textbook, q[0], DT, soft)
    log = plant.follow(servo, q, dq, np.zeros_like(q), DT)
    return log.true_q, log.command


def test_asymmetry_splits_both_frictions(tmp_path):
    effect = {"effect": "coulomb_asymmetry", "joint": 1, "dFc": 0.6, "dFv": 0.3}
    plant = bare(turntable(tmp_path), [effect], coulomb=3.0, viscous=2.0)
    assert torque_at(plant, 0.5)[0] == pytest.approx(3.6 + 2.3 * 0.5, abs=1e-4)
    assert torque_at(plant, -0.5)[0] == pytest.approx(-2.4 - 1.7 * 0.5, abs=1e-4)


@pytest.mark.parametrize("speed", [0.02, 0.08, 0.3, -0.08])
def test_stribeck_curve(tmp_path, speed):
    effect = {"effect": "stribeck", "joint": 1, "Fs": 1.5, "vs": 0.08, "delta": 1.6}
    plant = bare(turntable(tmp_path), [effect], coulomb=3.0, viscous=2.0)
    size = 3.0 + 1.5 * np.exp(-((abs(speed) / 0.08) ** 1.6)) + 2.0 * abs(speed)
    assert torque_at(plant, speed)[0] == pytest.approx(np.sign(speed) * size, rel=1e-3)


def test_stribeck_joint_breaks_away_late(tmp_path):
    effect = {"effect": "stribeck", "joint": 1, "Fs": 1.5, "vs": 0.08, "delta": 1.0}
    plant = bare(turntable(tmp_path), [effect], coulomb=3.0)
    for torque, moves in ((4.49, False), (4.51, True)):
        plant.reset(np.zeros(1))
        for _ in range(100):
            plant.step(np.array([torque]), DT)
        assert (plant.state.v[0] != 0) == moves


def test_power_law_friction(tmp_path):
    effect = {"effect": "nonlinear_viscous", "joint": 1, "Fp": 4.0, "p": 2.3}
    plant = bare(turntable(tmp_path), [effect], coulomb=1.0)
    for speed in (0.4, 1.5, -1.5):
        size = 1.0 + 4.0 * abs(speed) ** 2.3
        assert torque_at(plant, speed)[0] == pytest.approx(np.sign(speed) * size, rel=1e-4)


def test_worn_spot_raises_friction_in_both_directions(tmp_path):
    spot = {"height": 2.0, "centre": 0.3, "width": 0.2, "wave": 0.5, "cycles": 2.0}
    plant = bare(
        turntable(tmp_path), [{"effect": "position_friction", "joint": 1, **spot}], coulomb=3.0
    )
    t = np.arange(0, 4, DT)
    for way in (1.0, -1.0):
        q = (way * (0.4 * t - 0.8))[:, None]
        angle, torque = driven(plant, q, np.full_like(q, way * 0.4), DT)
        steady = slice(500, None)
        x = angle[steady, 0]
        level = 3.0 + 2.0 * np.exp(-0.5 * ((x - 0.3) / 0.2) ** 2) + 0.5 * np.sin(2 * x)
        np.testing.assert_allclose(torque[steady, 0], way * level, atol=0.03)


def test_load_friction_widens_the_gap_between_up_and_down(tmp_path):
    """Quasi-static: τ = load ± (Fc + μ|τ transmitted|), and the link sees the load alone."""
    plant = bare(
        pendulum(tmp_path, 4.0, 0.5),
        [{"effect": "load_friction", "joint": 1, "mu": 0.1}],
        coulomb=1.0,
        rotor_inertia=0.5,
    )
    load = -4.0 * G * 0.5 * np.sin(0.8)
    gap = []
    for speed in (0.02, -0.02):
        t = np.arange(0, 4, DT)
        q = (0.8 + speed * (t - 3.0))[:, None]
        angle, torque = driven(plant, q, np.full_like(q, speed), DT)
        gap.append(np.interp(0.8, *sorted_pair(angle[500:, 0], torque[500:, 0])))
    assert gap[0] - gap[1] == pytest.approx(2 * (1.0 + 0.1 * abs(load)), rel=1e-3)
    assert np.mean(gap) == pytest.approx(load, rel=1e-3)


def test_load_friction_may_be_larger_while_the_motor_drives(tmp_path):
    """Lifting costs the load, Fc and 16 % of it, letting it sink saves Fc and 4 %."""
    effect = {"effect": "load_friction", "joint": 1, "mu": 0.1, "dmu": 0.06}
    plant = bare(pendulum(tmp_path, 4.0, 0.5), [effect], coulomb=1.0, rotor_inertia=0.5)
    load = -4.0 * G * 0.5 * np.sin(0.8)
    for speed, expected in ((-0.02, 1.16 * load - 1.0), (0.02, 0.96 * load + 1.0)):
        t = np.arange(0, 4, DT)
        q = (0.8 + speed * (t - 3.0))[:, None]
        angle, torque = driven(plant, q, np.full_like(q, speed), DT)
        found = np.interp(0.8, *sorted_pair(angle[500:, 0], torque[500:, 0]))
        assert found == pytest.approx(expected, rel=1e-3)


def sorted_pair(x, y):
    order = np.argsort(x)
    return x[order], y[order]


def test_a_clamped_load_sticks_by_its_own_weight(tmp_path):
    """μ > 1 locks itself: no weight, however large, makes the joint slip."""
    effect = {"effect": "load_friction", "joint": 1, "mu": 1.05}
    plant = bare(pendulum(tmp_path, 40.0, 0.5), [effect], coulomb=0.01, rotor_inertia=0.5)
    plant.reset(np.array([1.0]))
    for _ in range(300):
        plant.step(np.zeros(1), DT)
    assert abs(plant.measure()[0][0] - 1.0) < 1e-6


def test_warming_by_time_follows_its_time_constant(tmp_path):
    effect = {"effect": "thermal_friction", "joint": 1, "loss": 0.4, "T": 3.0, "coulomb_share": 0.5}
    plant = bare(turntable(tmp_path), [effect], coulomb=3.0, viscous=4.0)
    t = np.arange(0, 10, DT)
    q = (0.8 * t)[:, None]
    _, torque = driven(plant, q, np.full_like(q, 0.8), DT)
    (cold, lost, constant), _ = curve_fit(
        lambda t, a, b, c: a - b * (1 - np.exp(-t / c)), t[1000:], torque[1000:, 0], (6, 1, 2)
    )
    assert constant == pytest.approx(3.0, rel=2e-3)
    assert cold == pytest.approx(3.0 + 3.2, rel=2e-3)
    assert lost == pytest.approx(0.5 * 0.4 * 3.0 + 0.4 * 3.2, rel=2e-3)
    assert plant.temperature()[0] == pytest.approx(25 + 20 * (1 - np.exp(-10 / 3.0)), abs=0.01)


def test_warming_by_friction_power_balances_heat(tmp_path):
    """Against an independent integration of x' = (P/P₀ - x)/T with P = |friction · speed|."""
    effect = {"effect": "thermal_friction", "joint": 1, "loss": 0.4, "T": 2.0, "law": "power"}
    plant = bare(turntable(tmp_path), [effect | {"power": 5.0}], coulomb=3.0, viscous=4.0)
    speed = 0.8

    def heat(_, x):
        return (speed * (3.0 * (1 - 0.2 * x) + 4.0 * speed * (1 - 0.4 * x)) / 5.0 - x) / 2.0

    plant.reset(np.zeros(1))
    plant.state.v[0] = speed
    t = np.arange(0, 3, DT)
    q = (speed * t)[:, None]
    driven_on(plant, q, np.full_like(q, speed))
    expected = solve_ivp(heat, (0, 3), [0.0], rtol=1e-8).y[0, -1]
    assert plant.state.warm[0] == pytest.approx(expected, rel=2e-3)


def test_standing_still_lets_it_cool(tmp_path):
    effect = {"effect": "thermal_friction", "joint": 1, "loss": 0.4, "T": 2.0, "law": "power"}
    plant = bare(turntable(tmp_path), [effect | {"start": 0.8}], coulomb=3.0)
    for _ in range(500):
        plant.step(np.zeros(1), DT)
    assert plant.state.warm[0] == pytest.approx(0.8 * np.exp(-0.5), rel=1e-6)


def test_shared_belt_drags_the_neighbour(tmp_path):
    """Outer joint turning alone: friction F·sign pulls the inner one, which has none itself."""
    for sign in (1.0, -1.0):
        effect = {"effect": "coupling_friction", "joints": [1, 2], "F": 2.0, "Fv": 0.5}
        plant = bare(turntable(tmp_path, 2), [effect | {"sign": sign}], coulomb=[0.0, 1.0])
        torque = torque_at(plant, 0.6, joint=1)
        assert torque[0] == pytest.approx(sign * (2.0 + 0.5 * 0.6), abs=2e-3)
        assert torque[1] == pytest.approx(1.0 + 2.0 + 0.5 * 0.6, abs=2e-3)


def test_shared_belt_holds_only_the_motion_it_sees(tmp_path):
    """With sign -1 the pair turns freely together and not against each other."""
    effect = {"effect": "coupling_friction", "joints": [1, 2], "F": 2.0, "sign": -1.0}
    plant = bare(turntable(tmp_path, 2), [effect])
    for _ in range(100):
        plant.step(np.array([1.5, -1.0]), DT)
    assert plant.state.v[0] == pytest.approx(plant.state.v[1], abs=1e-9)
    assert abs(plant.state.v[0]) > 1e-3


def test_friction_bent_by_a_neighbour(tmp_path):
    effect = {"effect": "cross_friction", "joints": [2, 1], "amplitude": 0.8, "cycles": 1.5}
    plant = bare(turntable(tmp_path, 2), [effect], coulomb=[1.0, 3.0])
    for angle in (-0.6, 0.9):
        t = np.arange(0, 2, DT)
        q = np.column_stack([np.full_like(t, angle), 0.4 * t])
        dq = np.column_stack([0 * t, 0 * t + 0.4])
        _, torque = driven(plant, q, dq, DT)
        expected = 3.0 + 0.8 * np.sin(1.5 * angle)
        assert torque[-200:, 1].mean() == pytest.approx(expected, rel=2e-3)
