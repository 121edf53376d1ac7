"""Links behind several springs swing together."""

from __future__ import annotations

import numpy as np
import pytest
import scipy

from pa10d.effects.swing import driven

DT, SAMPLES = 0.002, 1000
MASS = np.array([[50.0, 12.0], [12.0, 8.0]])  # of a palletiser's second and third link, kg·m²
STIFF = np.diag([70e3, 25e3]) + np.array([[-300.0, 80.0], [80.0, 150.0]])
DRAG = np.diag([60.0, 30.0])
REST, RATES = np.array([600.0, 120.0]), np.array([-2000.0, 700.0])


def always(matrix: np.ndarray) -> np.ndarray:
    return np.repeat(matrix[None], SAMPLES, axis=0)


@pytest.mark.long
def test_two_springs_swing_as_an_integrator_of_their_coupled_equation_says():
    """Closed form: the matrix exponential of the homogeneous equation, from a load held still."""
    load = np.zeros((SAMPLES, 2, 1))
    equation = always(MASS), always(DRAG), always(STIFF)
    found = driven(load, REST[:, None], RATES[:, None], equation, DT)[:, :, :, 0]
    there = np.linalg.solve(MASS, np.hstack([-STIFF, -DRAG]))
    system = np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), there])
    begins = np.concatenate([np.linalg.solve(STIFF, REST), np.linalg.solve(STIFF, RATES)])
    step, state = scipy.linalg.expm(system * DT), begins
    true = np.zeros((SAMPLES, 4))
    for k in range(SAMPLES):
        true[k], state = state, step @ state
    largest = np.abs(true[:, :2]).max(axis=0)
    assert np.all(np.abs(found[0] - true[:, :2]).max(axis=0) < 0.05 * largest)
    assert np.all(np.abs(found[0, :200] - true[:200, :2]).max(axis=0) < 0.01 * largest)


def test_springs_that_do_not_touch_each_other_swing_as_each_alone():
    rng = np.random.default_rng(1)
    load = np.cumsum(rng.standard_normal((SAMPLES, 2, 3)), axis=0)
    equation = tuple(always(np.diag(np.diag(x))) for x in (MASS, DRAG, STIFF))
    rest, rates = rng.standard_normal((2, 2, 3))
    both = driven(load, rest, rates, equation, DT)
    for e in range(2):
        own = tuple(x[:, e : e + 1, e : e + 1] for x in equation)
        alone = driven(load[:, e : e + 1], rest[e : e + 1], rates[e : e + 1], own, DT)
        error = np.abs(both[:, :, e] - alone[:, :, 0])
        assert np.all(error < 0.02 * np.abs(alone[:, :, 0]).max(axis=1, keepdims=True))
