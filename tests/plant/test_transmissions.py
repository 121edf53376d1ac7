"""Springs and gaps between rotor and link."""

import numpy as np
import pytest
from plant_robots import G, bare, pendulum, turntable

DT = 1e-3


def elastic(stiffness, damping=0.0):
    return {"effect": "joint_elasticity", "joint": 1, "K": stiffness, "D": damping}


def ring(plant, steps):
    """Rotor angles after the link has been given a push."""
    plant.state.v[0] = 0.2
    out = []
    for _ in range(steps):
        plant.step(np.zeros(plant.n), DT)
        out.append(plant.state.q[plant.physics.transmission.rotor[0]])
    return np.array(out)


def test_two_masses_ring_at_their_resonance(tmp_path):
    plant = bare(turntable(tmp_path, inertia=2.0), [elastic(1000.0)], rotor_inertia=0.5)
    angle = ring(plant, 8000)
    drift = np.polynomial.Polynomial.fit(np.arange(8000), angle, 1)(np.arange(8000))
    spectrum = np.abs(np.fft.rfft((angle - drift) * np.hanning(8000), 2**17))
    frequency = np.argmax(spectrum) / (2**17 * DT)
    expected = np.sqrt(1000.0 * (1 / 2.0 + 1 / 0.5)) / (2 * np.pi)
    assert frequency == pytest.approx(expected, rel=3e-3)


def test_ringing_keeps_its_energy_without_damping_and_loses_it_with(tmp_path):
    profile = turntable(tmp_path, inertia=2.0)
    undamped = ring(bare(profile, [elastic(1000.0)], rotor_inertia=0.5), 6000)
    damped = ring(bare(profile, [elastic(1000.0, 2.0)], rotor_inertia=0.5), 6000)

    def swing(angle, part):
        steps = np.arange(len(angle))
        rest = angle - np.polynomial.Polynomial.fit(steps, angle, 1)(steps)
        return np.ptp(rest[part])

    early, late = slice(0, 600), slice(5000, 5600)
    assert swing(undamped, late) == pytest.approx(swing(undamped, early), rel=0.02)
    # both ends damped: amplitude falls as exp(-D/2 (1/J1 + 1/J2) t)
    at = np.abs(np.diff(damped, 2))[:, None]
    fall = at[2000:2500].max() / at[500:1000].max()
    assert fall == pytest.approx(np.exp(-0.5 * 2.0 * 2.5 * 1.5), rel=0.05)


def test_encoder_sees_the_rotor_and_gravity_winds_the_spring(tmp_path):
    plant = bare(pendulum(tmp_path, 4.0, 0.5), [elastic(400.0, 30.0)], rotor_inertia=0.5)
    plant.reset(np.array([0.6]))
    held = 0.0
    for _ in range(8000):  # hold the rotor with a stiff spring of our own
        rotor, speed = plant.state.q[1], plant.state.v[1]
        held = 5000.0 * (0.6 - rotor) - 150.0 * speed
        plant.step(np.array([held]), DT)
    link = plant.state.q[0]
    weight = 4.0 * G * 0.5 * np.sin(link)
    assert plant.measure()[0][0] == plant.state.q[1]
    assert link - plant.state.q[1] == pytest.approx(weight / 400.0, rel=1e-3)
    assert held == pytest.approx(-weight, rel=1e-3)
    assert plant.state.load[0] == pytest.approx(-weight, rel=1e-3)


def gap(half, stiffness=2e5, damping=200.0):
    return {"effect": "backlash", "joint": 1, "b": half, "K": stiffness, "D": damping}


def test_in_the_gap_the_rotor_is_alone(tmp_path):
    """Until the gap is crossed only the rotor accelerates; afterwards both do."""
    plant = bare(turntable(tmp_path, inertia=2.0), [gap(0.05)], rotor_inertia=0.5, coulomb=0.0)
    torque, t = 1.0, 0.0
    while plant.state.q[1] - plant.state.q[0] < 0.05:
        assert plant.state.q[0] == 0.0
        plant.step(np.array([torque]), DT)
        t += DT
    assert t == pytest.approx(np.sqrt(2 * 0.05 * 0.5 / torque), abs=2 * DT)
    for _ in range(4000):
        plant.step(np.array([torque]), DT)
    before = plant.state.v[1]
    for _ in range(1000):
        plant.step(np.array([torque]), DT)
    assert plant.state.v[1] - before == pytest.approx(torque / 2.5, rel=0.02)


def test_reversal_crosses_the_whole_gap(tmp_path):
    """Push one way until the teeth touch, then the other: the rotor travels 2b alone."""
    plant = bare(turntable(tmp_path, inertia=500.0), [gap(0.02)], rotor_inertia=0.5, coulomb=0.5)
    for way in (1.0, -1.0):
        for _ in range(4000):
            plant.step(np.array([1.0 * way]), DT)
        assert plant.state.q[1] - plant.state.q[0] == pytest.approx(0.02 * way, abs=1e-4)


def test_momentum_survives_the_impact(tmp_path):
    plant = bare(turntable(tmp_path, inertia=2.0), [gap(0.03)], rotor_inertia=0.5)
    plant.state.v[1] = 1.0
    for _ in range(3000):
        plant.step(np.zeros(1), DT)
    momentum = 2.0 * plant.state.v[0] + 0.5 * plant.state.v[1]
    assert momentum == pytest.approx(0.5, rel=1e-9)
    kinetic = 0.5 * 2.0 * plant.state.v[0] ** 2 + 0.25 * plant.state.v[1] ** 2
    assert kinetic < 0.25


def test_soft_gap_is_both_in_series(tmp_path):
    plant = bare(turntable(tmp_path), [gap(0.01, 3000.0), elastic(1500.0, 5.0)], rotor_inertia=0.5)
    tr = plant.physics.transmission
    assert tr.stiffness[0] == pytest.approx(1000.0)
    assert tr.gap[0] == 0.01
