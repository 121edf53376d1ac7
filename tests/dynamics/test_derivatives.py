"""Derivatives of the torque against Pinocchio, and against differences where it cannot follow."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from test_regressor import TILTED, random_parameters, seeds, states, trees
from trees import ALL

from pa10d.dynamics import inverse_dynamics, robot_from_urdf, sensitivities


@pytest.mark.parametrize("name", sorted(ALL))
def test_agrees_with_pinocchio(name):
    robot = robot_from_urdf(ALL[name], gravity=TILTED)
    q, dq, ddq = states(robot, 20, 5)
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
