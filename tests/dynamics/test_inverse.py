"""The torque of rigid bodies against Pinocchio and the regressor, which shares no kernel."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from test_regressor import TILTED, random_parameters, states
from trees import ALL

from pa10d.dynamics import inverse_dynamics, regressor, robot_from_urdf
from pa10d.dynamics.lanes import LANES


@pytest.mark.parametrize("name", sorted(ALL))
def test_is_pinocchios_rnea(name):
    robot = robot_from_urdf(ALL[name], gravity=TILTED)
    q, dq, ddq = states(robot, 2 * LANES + 3, 4)  # two full blocks and a part of one
    ours = inverse_dynamics(robot, robot.parameters, q, dq, ddq)
    model, order = robot.pinocchio()
    data = model.createData()
    for s in range(len(q)):
        theirs = pin.rnea(model, data, q[s][order], dq[s][order], ddq[s][order])
        np.testing.assert_allclose(ours[s][order], theirs, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("samples", [0, 1, 2, LANES - 1, LANES, LANES + 1, 2 * LANES + 3])
@pytest.mark.parametrize("name", sorted(ALL))
def test_is_the_regressors_torque_of_any_parameters(name, samples):
    """Those of a fit need not be bodies'."""
    robot = robot_from_urdf(ALL[name], gravity=TILTED)
    moved = list(states(robot, samples, 6))
    h = random_parameters(robot, samples)
    found = inverse_dynamics(robot, h, *moved)
    expected = regressor(robot, *moved) @ h.ravel()
    scale = 1.0 + np.abs(expected).max(initial=0.0)
    assert found.shape == (samples, robot.n)
    np.testing.assert_allclose(found / scale, expected / scale, rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", sorted(ALL))
def test_a_sample_knows_nothing_of_those_beside_it(name):
    """Samples are worked on in blocks: one that is no number spoils none of the others."""
    robot = robot_from_urdf(ALL[name], gravity=TILTED)
    moved = np.stack(list(states(robot, 2 * LANES + 3, 7)))
    found = inverse_dynamics(robot, robot.parameters, *moved)
    lost = moved.copy()
    lost[:, 1::LANES] = np.nan
    spoilt = np.isnan(lost).any(axis=(0, 2))
    left = inverse_dynamics(robot, robot.parameters, *lost)
    np.testing.assert_array_equal(left[~spoilt], found[~spoilt])
    assert np.isnan(left[spoilt]).all()
