"""Derivatives of the torque against Pinocchio, and against differences where it cannot follow."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from test_regressor import TILTED, random_parameters, seeds, states, trees
from trees import ALL

from pa10d.dynamics import inverse_dynamics, robot_from_urdf, sensitivities
from pa10d.dynamics.lanes import LANES


@pytest.mark.parametrize("name", sorted(ALL))
def test_agrees_with_pinocchio(name):
    robot = robot_from_urdf(ALL[name], gravity=TILTED)
    q, dq, ddq = states(robot, 2 * LANES + 3, 5)  # two full blocks and a part of one
    by_q, by_dq, by_ddq = sensitivities(robot, robot.parameters, q, dq, ddq)
    model, order = robot.pinocchio()
    data = model.createData()
    for s in range(len(q)):
        pin.computeRNEADerivatives(model, data, q[s][order], dq[s][order], ddq[s][order])
        mass = np.triu(data.M) + np.triu(data.M, 1).T
        for ours, theirs in ((by_q, data.dtau_dq), (by_dq, data.dtau_dv), (by_ddq, mass)):
            np.testing.assert_allclose(ours[:, s][np.ix_(order, order)].T, theirs, atol=1e-9)


@settings(max_examples=20, deadline=None)
@given(trees, seeds)
def test_parameters_need_not_be_those_of_bodies(name, seed):
    """A fit's parameters have negative masses now and then; what holds is linear in them."""
    robot = robot_from_urdf(ALL[name], gravity=TILTED)
    q, dq, ddq = states(robot, 5, seed)
    h = random_parameters(robot, seed)

    def torque(q, dq, ddq):
        return inverse_dynamics(robot, h, q, dq, ddq)

    found = sensitivities(robot, h, q, dq, ddq)
    for j, unit in enumerate(np.eye(robot.n)):
        step = 1e-5 * unit
        expected = (
            (torque(q + step, dq, ddq) - torque(q - step, dq, ddq)) / 2e-5,
            (torque(q, dq + unit, ddq) - torque(q, dq - unit, ddq)) / 2.0,
            torque(q, dq, ddq + unit) - torque(q, dq, ddq),
        )
        for ours, theirs in zip(found, expected, strict=True):
            scale = 1.0 + np.abs(theirs).max()
            np.testing.assert_allclose(ours[j] / scale, theirs / scale, atol=1e-6)


@pytest.mark.parametrize("samples", [0, 1, LANES - 1, LANES, LANES + 1, 2 * LANES + 3])
@pytest.mark.parametrize("name", sorted(ALL))
def test_a_sample_knows_nothing_of_those_beside_it(name, samples):
    """Samples are worked on in blocks: neither their number nor one that is no number changes what
    is found at the others."""
    robot = robot_from_urdf(ALL[name], gravity=TILTED)
    moved = np.stack(list(states(robot, samples, 7)))
    found = np.stack(sensitivities(robot, robot.parameters, *moved))
    assert found.shape == (3, robot.n, samples, robot.n)
    alone = [sensitivities(robot, robot.parameters, *moved[:, k : k + 1]) for k in range(samples)]
    scale = 1.0 + np.abs(found).max(initial=0.0)
    for k, one in enumerate(alone):
        np.testing.assert_allclose(
            found[:, :, k] / scale, np.stack(one)[:, :, 0] / scale, atol=1e-13
        )
    lost = moved.copy()
    lost[:, samples // 3 :: LANES] = np.nan
    spoilt = np.isnan(lost).any(axis=(0, 2))
    left = np.stack(sensitivities(robot, robot.parameters, *lost))
    np.testing.assert_array_equal(left[:, :, ~spoilt], found[:, :, ~spoilt])
    assert np.isnan(left[:, :, spoilt]).any(axis=(0, 1, 3)).all()
