"""An encoder whose noise, differentiated twice, is larger than the load that a joint carries."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from small_machines import machine
from two_links import RATE, V0, motion, recordings, robot, state_of, textbook, textbook_torque

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.suspects import suspicion
from pa10d.dynamics import inverse_dynamics
from pa10d.effects import Context
from pa10d.effects.base import smooth_sign
from pa10d.identify import identify
from pa10d.measurement.motion import motion_bands
from pa10d.measurement.signals import Lowpass

NOISE = 8e-4  # rad: some 37 rad/s² once it is differentiated, beside motion of 5 rad/s²
MU = 0.15
C3 = 5e-4  # 1/(N·m)²: a tenth of the largest torques


def noisy(law):
    """Recordings with one more torque in joint 2, and noise on every angle."""
    rng = np.random.default_rng(5)
    runs = recordings(3, extra=law, noise=0.02)
    return {k: replace(r, q=r.q + NOISE * rng.standard_normal(r.q.shape)) for k, r in runs.items()}


def load(q, dq, ddq):
    return inverse_dynamics(robot(), robot().parameters, q, dq, ddq)[:, 1]


def rubbing(t, q, dq, ddq):
    friction = MU * np.abs(load(q, dq, ddq)) * smooth_sign(dq[:, 1], V0)
    return np.column_stack([0 * t, friction])


def saturated(t, q, dq, ddq):
    """τ = τ_true + c3·τ³ in the second joint."""
    true = textbook_torque(q, dq, ddq)[:, 1]
    torque = true
    for _ in range(50):
        torque = true + C3 * torque**3
    return np.column_stack([0 * t, torque - true])


@pytest.fixture(scope="module")
def rubs():
    return state_of(runs := noisy(rubbing), textbook(runs, cutoff=3.0))


def found(state, effect):
    search = Search(state, suspicion((effect, (1,)), 2), len(state.terms))
    search.state.push(search.best(*search.suspects[0]).term)
    search.settle()
    return search.state.terms[-1], search.state


def test_friction_of_a_load_is_not_that_of_its_noise(rubs):
    term, state = found(rubs.copy(), "load_friction")
    assert term.coefficients[0] == pytest.approx(MU, rel=0.15)
    assert state.fit.rms()[1] < 0.3 * rubs.fit.rms()[1]


@pytest.mark.long
def test_a_cube_of_a_torque_is_not_that_of_its_noise():
    runs = noisy(saturated)
    start = state_of(runs, textbook(runs, cutoff=3.0))
    term, _ = found(start, "torque_saturation")
    assert term.coefficients[0] == pytest.approx(C3, rel=0.2)


def test_motion_ends_where_its_acceleration_grows_again():
    t, q, _, _ = motion(4)
    light = Lowpass(len(t), RATE, 50.0)
    rng = np.random.default_rng(1)
    clean, loud = (light(q + n * rng.standard_normal(q.shape), 2) for n in (0.0, NOISE))
    assert motion_bands(clean[100:-100], RATE, 10.0, 50.0) == (np.inf, np.inf)
    assert max(motion_bands(loud[100:-100], RATE, 10.0, 50.0)) < 20.0


def test_what_is_wanted_and_not_measured_has_no_noise(rubs):
    seen = rubs.train.contexts[0]
    assert np.isfinite(seen.quieting.up_to).all()
    wanted = Context(robot(), seen.t, seen.q, seen.dq, seen.ddq, seen.rigid, seen.total)
    assert wanted.quiet_load is wanted.load
    assert wanted.quiet_total is wanted.total
    assert np.std(seen.quiet_load[:, 1]) < 0.9 * np.std(wanted.load[:, 1])


@pytest.mark.long
def test_two_alike_gears_rub_alike():
    """A double pendulum; by least squares of its filtered torque with the load of gravity alone,
    joint 1 has 0.0665."""
    robot, (train, valid) = machine("double_pendulum", ["train1.csv", "valid1.csv"])
    model = identify([train], robot, name="m0")
    told = diagnose(model, [train], [valid], only=("load_friction", []))
    mu = {f.term.joints[0]: f.parameters["mu"] for f in told.findings}
    assert sorted(mu) == [0, 1]
    for value in mu.values():
        assert 0.05 < value.value < 0.085
        assert value.std_error < 0.4 * value.value
