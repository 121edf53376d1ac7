"""The arm without effects: equations of motion, energy, sticking."""

import numpy as np
import pinocchio as pin
import pytest
from plant_robots import (
    G,
    bare,
    pendulum,
    pinocchio_model,
    seven_axes,
    sliding,
    turntable,
    unexplained,
)

from backends.virtual.datasets import motion_of, reach_of, run_motion
from backends.virtual.plant import build
from backends.virtual.plant.servo import servo_for
from pa10d.profile import load_profile

DT = 0.002
ROTORS = [0.75, 0.75, 0.2, 0.2, 0.006, 0.006, 0.006]


@pytest.mark.by_default("train_b")
@pytest.mark.parametrize("kind", ["train_a", "train_b", "valid_b"])
def test_torque_is_newton_euler_plus_friction(kind):
    profile = seven_axes()
    plant = build(profile, noise="none", resolution=0.0, dynamics={"spread": 0.2, "seed": 3})
    motion = motion_of(kind, np.random.default_rng(3), reach_of(profile), 12.0)
    run, _ = run_motion(plant, profile, motion, 12.0)
    left = unexplained(plant, profile.urdf, run.q, run.tau, DT)
    steady = sliding(left["dq"], 0.02, 12)
    assert steady.mean() > 0.3
    rms = np.sqrt(np.mean(left["rest"][steady] ** 2, axis=0))
    assert np.all(rms < 3e-5 * np.sqrt(np.mean(left["torque"][steady] ** 2, axis=0)))


def test_what_a_known_weight_told_changes_no_arm():
    """A torque gain corrects what pa10d reads and asks for; the motor stays the motor it is."""
    profile = load_profile("ur5e")
    drives = [drive.model_copy(update={"torque_gain": 1.25}) for drive in profile.drives]
    told = profile.model_copy(update={"drives": drives})
    books = [build(one, dynamics={"spread": 0.2}).textbook for one in (profile, told)]
    for figure in ("rotor_inertia", "coulomb", "viscous", "effort"):
        np.testing.assert_array_equal(*(getattr(book, figure) for book in books))


def energy(model, plant):
    data, q, v = model.createData(), plant.state.q, plant.state.v
    spinning = 0.5 * plant.textbook.rotor_inertia @ v**2
    links = pin.computeKineticEnergy(model, data, q, v)
    return spinning + links + pin.computePotentialEnergy(model, data, q)


def test_energy_is_kept_without_friction_and_better_with_finer_steps():
    profile, drift = seven_axes(), []
    for substep in (1e-3, 5e-4):
        plant = bare(profile, rotor_inertia=ROTORS, substep=substep)
        model = pinocchio_model(plant, profile.urdf)
        plant.reset(np.array([0.3, 0.8, 0.2, 1.0, 0.5, -0.7, 0.1]))
        start, most = energy(model, plant), 0.0
        for _ in range(300):
            plant.step(np.zeros(7), DT)
            most = max(most, abs(energy(model, plant) - start))
        assert np.abs(plant.state.v).max() > 3.0
        drift.append(most)
    assert drift[1] < 3e-4  # J
    assert drift[1] < 0.28 * drift[0]  # second order


def test_friction_only_ever_takes_energy():
    profile = seven_axes()
    plant = build(profile, noise="none")
    model = pinocchio_model(plant, profile.urdf)
    plant.reset(np.array([0.3, 1.2, 0.2, 1.4, 0.5, -0.7, 0.1]))
    last = energy(model, plant)
    for _ in range(1000):
        plant.step(np.zeros(7), DT)
        now = energy(model, plant)
        assert now <= last + 1e-9
        last = now


def test_a_pendulum_swings_at_its_own_frequency(tmp_path):
    plant = bare(pendulum(tmp_path, 4.0, 0.5))
    plant.reset(np.array([np.pi - 0.02]))
    angle = []
    for _ in range(4000):
        plant.step(np.zeros(1), DT)
        angle.append(plant.measure()[0][0] - np.pi)
    rising = np.flatnonzero((np.array(angle[:-1]) < 0) & (np.array(angle[1:]) >= 0))
    period = (rising[-1] - rising[0]) * DT / (len(rising) - 1)
    inertia = 4.0 * 0.25 + 0.01
    assert period == pytest.approx(2 * np.pi * np.sqrt(inertia / (4.0 * G * 0.5)), rel=1e-3)


def test_a_joint_sticks_below_its_friction_and_slides_above(tmp_path):
    plant = bare(turntable(tmp_path), coulomb=3.0)
    for torque, moves in ((2.999, False), (-2.999, False), (3.001, True), (-3.001, True)):
        plant.reset(np.array([0.4]))
        for _ in range(200):
            plant.step(np.array([torque]), DT)
        assert (plant.state.v[0] != 0.0) == moves
        assert (plant.measure()[0][0] != 0.4) == moves
        if not moves:
            assert plant.state.rubbing[0] == pytest.approx(torque, abs=1e-9)


def test_a_heavy_arm_hangs_on_its_stiction_for_good():
    profile = seven_axes()
    plant = bare(profile, coulomb=[8, 60, 4, 30, 1, 1, 1], rotor_inertia=0.1)
    pose = np.array([0.2, 0.5, -0.4, 0.9, 0.3, 0.6, 0.0])
    plant.reset(pose)
    for _ in range(500):
        plant.step(np.zeros(7), DT)
    model = pinocchio_model(plant, profile.urdf)
    gravity = pin.rnea(model, model.createData(), pose, np.zeros(7), np.zeros(7))
    assert np.all(plant.state.v == 0.0)
    np.testing.assert_array_equal(plant.measure()[0], pose)
    np.testing.assert_allclose(plant.state.rubbing, -gravity, atol=1e-7)


def test_coasting_stops_where_the_friction_says(tmp_path):
    plant = bare(turntable(tmp_path, inertia=2.0), coulomb=3.0)
    plant.state.v[0] = 1.5
    for _ in range(1000):
        plant.step(np.zeros(1), DT)
    assert plant.state.v[0] == 0.0
    assert plant.measure()[0][0] == pytest.approx(0.5 * 2.0 * 1.5**2 / 3.0, rel=1e-6)


def test_viscous_friction_decays_exponentially(tmp_path):
    plant = bare(turntable(tmp_path, inertia=2.0), viscous=4.0, rotor_inertia=1.0)
    plant.state.v[0] = 1.0
    for _ in range(500):
        plant.step(np.zeros(1), DT)
    assert plant.state.v[0] == pytest.approx(np.exp(-4.0 / 3.0), rel=1e-6)


def test_joints_that_stick_together_share_the_load_and_stay(tmp_path):
    """Two coaxial turntables: pushing the inner one must not creep the outer one."""
    plant = bare(turntable(tmp_path, 2), coulomb=[2.0, 1.0])
    plant.reset(np.zeros(2))
    for _ in range(300):
        plant.step(np.array([1.9, -0.9]), DT)
    np.testing.assert_array_equal(plant.state.v, 0.0)
    np.testing.assert_allclose(plant.state.rubbing, [1.9, -0.9], atol=1e-9)


def test_step_by_step_and_in_one_go_are_the_same_to_the_bit():
    profile = seven_axes()
    options = {"noise": "coloured", "seed": 4, "dynamics": {"spread": 0.2}}
    motion = motion_of("train_a", np.random.default_rng(5), reach_of(profile), 2.0)
    q, dq, _ = motion.sample(np.arange(300) * DT)
    whole, stepped = build(profile, **options), build(profile, **options)
    whole.reset(q[0])
    stepped.reset(q[0])
    servo = servo_for(whole.physics.arm, whole.textbook, q[0], DT, np.zeros(7, bool))
    log = whole.follow(servo, q, dq, np.zeros_like(q), DT)
    for k, command in enumerate(log.command):
        stepped.step(command, DT)
        angle, torque = stepped.measure()
        np.testing.assert_array_equal(angle, log.q[k])
        np.testing.assert_array_equal(torque, log.torque[k])
