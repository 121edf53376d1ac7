"""Links behind several springs swing together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy
from effect_motions import arm_context

from pa10d.effects.swing import driven, swung_freely
from pa10d.effects.twist import springs_of, twisted_torque

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
    where, fast = np.linalg.solve(STIFF, REST), np.linalg.solve(STIFF, RATES)
    found = driven(load, where[:, None], fast[:, None], equation, DT)[:, :, :, 0]
    there = np.linalg.solve(MASS, np.hstack([-STIFF, -DRAG]))
    system = np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), there])
    begins = np.concatenate([where, fast])
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
    where, fast = rng.standard_normal((2, 2, 3))
    both = driven(load, where, fast, equation, DT)
    for e in range(2):
        own = tuple(x[:, e : e + 1, e : e + 1] for x in equation)
        alone = driven(load[:, e : e + 1], where[e : e + 1], fast[e : e + 1], own, DT)
        error = np.abs(both[:, :, e] - alone[:, :, 0])
        assert np.all(error < 0.02 * np.abs(alone[:, :, 0]).max(axis=1, keepdims=True))


@pytest.mark.parametrize("joints", [(1,), (3, 1)])
def test_what_a_beginning_changes_is_the_difference_of_two_swings(joints):
    """Each spring's link begins a little farther, or faster: the exact torque changes by what the
    homogeneous solutions foretell."""
    rotors, stiffness = {1: 0.3, 3: 0.2}, {1: 30e3, 3: 6e3}
    springs = tuple((j, stiffness[j], 0.03, rotors[j]) for j in joints)
    context = replace(arm_context(seconds=3.0), springs=springs)

    def torque(wound):
        seen = context.with_wound(wound)
        return sum(
            twisted_torque(seen, j, k, zeta, rotor=rotor, closely=True)[:, :, 0]
            for j, k, zeta, rotor in springs
        )

    still = {j: (0.0, 0.0) for j in joints}
    found = swung_freely(context.with_wound(still), springs_of(context), [1.0] * len(joints))
    for e, j in enumerate(joints):
        for one, size in ((0, 5.0), (1, 300.0)):
            step = [0.0, 0.0]
            step[one] = size
            true = torque({**still, j: (step[0], step[1])}) - torque(still)
            error = np.abs(size * found[:, :, e, one] - true).max()
            assert error < 0.03 * np.abs(true).max()
