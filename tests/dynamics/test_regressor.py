"""The regressor against Pinocchio and against laws of mechanics."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trees import ALL, BRANCHED, PRISMATIC, SERIAL

from pa10d.dynamics import inverse_dynamics, regressor, robot_from_urdf

TILTED = np.array([3.0, -4.0, -8.0])
seeds = st.integers(0, 10_000)
trees = st.sampled_from(sorted(ALL))


def states(robot, samples, seed):
    rng = np.random.default_rng(seed)
    return (rng.normal(0, s, (samples, robot.n)) for s in (1.5, 2.0, 5.0))


def random_parameters(robot, seed):
    return np.random.default_rng(seed).normal(size=(robot.n, 10))


@pytest.mark.parametrize("name", sorted(ALL))
@pytest.mark.parametrize("gravity", [np.array([0, 0, -9.81]), TILTED], ids=["upright", "tilted"])
def test_agrees_with_pinocchio_per_sample(name, gravity):
    robot = robot_from_urdf(ALL[name], gravity=gravity)
    q, dq, ddq = states(robot, 20, 3)
    ours = regressor(robot, q, dq, ddq)
    model, order = robot.pinocchio()
    data = model.createData()
    for s in range(len(q)):
        theirs = pin.computeJointTorqueRegressor(
            model, data, q[s][order], dq[s][order], ddq[s][order]
        )
        for i, ours_i in enumerate(order):
            for k, ours_k in enumerate(order):
                np.testing.assert_allclose(
                    ours[s, ours_i, 10 * ours_k : 10 * ours_k + 10],
                    theirs[i, 10 * k : 10 * k + 10],
                    atol=1e-11,
                )


def test_a_subset_of_joints_is_the_arm_with_the_others_locked():
    robot = robot_from_urdf(SERIAL, ["j4", "j1", "j3"])
    whole = robot_from_urdf(SERIAL)
    q, dq, ddq = states(robot, 10, 5)
    full = [np.zeros((10, 5)) for _ in range(3)]
    for target, source in zip(full, (q, dq, ddq), strict=True):
        target[:, [3, 0, 2]] = source
    part = inverse_dynamics(robot, robot.parameters, q, dq, ddq)
    all_joints = inverse_dynamics(whole, whole.parameters, *full)
    np.testing.assert_allclose(part, all_joints[:, [3, 0, 2]], atol=1e-10)


@given(trees, seeds, seeds)
@settings(max_examples=20, deadline=None)
def test_torque_is_linear_in_the_parameters(name, seed, other):
    robot = robot_from_urdf(ALL[name])
    q, dq, ddq = states(robot, 4, seed)
    a, b = random_parameters(robot, seed), random_parameters(robot, other + 1)
    y = regressor(robot, q, dq, ddq)
    np.testing.assert_allclose(
        inverse_dynamics(robot, a + 2 * b, q, dq, ddq),
        y @ a.ravel() + 2 * (y @ b.ravel()),
        rtol=1e-9,
        atol=1e-9,
    )


@given(trees, seeds, st.integers(-3, 3))
@settings(max_examples=20, deadline=None)
def test_a_whole_turn_changes_nothing(name, seed, turns):
    robot = robot_from_urdf(ALL[name])
    q, dq, ddq = states(robot, 4, seed)
    turned = q + np.where(robot.prismatic, 0.0, 2 * np.pi * turns)
    np.testing.assert_allclose(
        regressor(robot, turned, dq, ddq), regressor(robot, q, dq, ddq), atol=1e-9
    )


@pytest.mark.long
@given(trees, seeds)
@settings(max_examples=20, deadline=None)
def test_power_is_the_change_of_energy(name, seed):
    """τ·q̇ = dE/dt with E from Pinocchio, along a motion with constant acceleration."""
    robot = robot_from_urdf(ALL[name])
    q, dq, ddq = (x[0] for x in states(robot, 1, seed))
    model, order = robot.pinocchio()
    data = model.createData()

    def energy(t):
        at, speed = q + dq * t + ddq * t * t / 2, dq + ddq * t
        kinetic = pin.computeKineticEnergy(model, data, at[order], speed[order])
        return kinetic + pin.computePotentialEnergy(model, data, at[order])

    h = 1e-5
    rate = (energy(h) - energy(-h)) / (2 * h)
    torque = inverse_dynamics(robot, robot.parameters, q[None], dq[None], ddq[None])[0]
    assert torque @ dq == pytest.approx(rate, rel=1e-5, abs=1e-4)


@given(trees, seeds)
@settings(max_examples=10, deadline=None)
def test_turning_base_and_gravity_together_changes_nothing(name, seed):
    """Only the direction of gravity in the base counts, for any mounting."""
    robot = robot_from_urdf(ALL[name])
    q, dq, ddq = states(robot, 3, seed)
    axis = np.random.default_rng(seed).normal(size=3)
    rotation = pin.exp3(axis)
    turned = robot.with_gravity(rotation.T @ robot.gravity)
    first = robot.parent < 0
    turned.rotation[first] = rotation.T @ turned.rotation[first]
    turned.translation[first] = turned.translation[first] @ rotation
    np.testing.assert_allclose(
        inverse_dynamics(turned, robot.parameters, q, dq, ddq),
        inverse_dynamics(robot_from_urdf(ALL[name]), robot.parameters, q, dq, ddq),
        atol=1e-9,
    )


def test_chosen_columns_and_given_memory():
    robot = robot_from_urdf(BRANCHED)
    q, dq, ddq = states(robot, 6, 8)
    full = regressor(robot, q, dq, ddq)
    chosen = np.array([3, 17, 40])
    np.testing.assert_array_equal(regressor(robot, q, dq, ddq, chosen), full[:, :, chosen])
    memory = np.zeros((robot.n, 3, 6))
    filled = regressor(robot, q, dq, ddq, chosen, out=memory.transpose(2, 0, 1))
    np.testing.assert_array_equal(filled, full[:, :, chosen])
    np.testing.assert_array_equal(memory[2, 1], full[:, 2, 17])


def test_a_link_only_loads_joints_that_carry_it():
    robot = robot_from_urdf(BRANCHED)
    q, dq, ddq = states(robot, 30, 9)
    loads = (
        np.abs(regressor(robot, q, dq, ddq)).max(axis=0).reshape(robot.n, robot.n, 10).max(axis=2)
    )
    assert not np.any(loads[~robot.carries()])
    assert np.all(loads[robot.carries()] > 0)


def test_prismatic_joint_carries_weight():
    robot = robot_from_urdf(PRISMATIC)
    still = np.zeros((1, robot.n))
    torque = inverse_dynamics(robot, robot.parameters, still, still, still)
    model, order = robot.pinocchio()
    gravity = pin.computeGeneralizedGravity(model, model.createData(), still[0])
    np.testing.assert_allclose(torque[0][order], gravity, atol=1e-12)
