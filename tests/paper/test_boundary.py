"""The boundary velocity of joints whose friction is known."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from how_often import how_often
from pydantic import ValidationError

from pa10d.common.errors import UserError
from pa10d.common.jsonable import parsed, plain
from pa10d.dynamics import inverse_dynamics
from pa10d.figures.of_boundary import convergence, friction_chart
from pa10d.measurement.recording import Recording
from pa10d.paper.boundary import boundary_velocity
from pa10d.paper.single_joint import single_joint
from pa10d.paper.told import ToldBoundary
from tests.paper.swings import (
    COULOMB,
    INERTIA,
    VISCOUS,
    bristles,
    pendulum,
    stribeck,
    swings,
)


def found(recordings, gravity="none", robot=None, **more):
    return boundary_velocity(
        single_joint(recordings, robot or pendulum(), 0, gravity=gravity, **more)
    )


def test_linear_friction_has_no_boundary_and_its_parameters_are_found():
    result = found(swings())
    assert result.decided_by == "none"
    assert result.threshold == 0.0
    assert result.finest < 0.01
    values = result.sweep.values[5]
    assert values == pytest.approx([INERTIA, COULOMB, VISCOUS], rel=0.01)


@pytest.mark.long
def test_noise_alone_makes_no_boundary():
    false = sum(found(swings(noise=1.0, seed=seed)).threshold > 0 for seed in range(12))
    assert false <= 1


@pytest.mark.by_default("3.0-0.05")
@pytest.mark.parametrize(("rise", "speed"), [(3.0, 0.05), (3.0, 0.12), (1.5, 0.08), (5.0, 0.2)])
def test_the_boundary_is_where_extra_friction_becomes_immaterial(rise, speed):
    """Between where it is 10 % of the Coulomb level and where it is 0.5 % of it."""
    result = found(swings(stribeck(rise, speed)))
    lower, upper = (speed * np.sqrt(np.log(rise / (share * COULOMB))) for share in (0.1, 0.005))
    assert result.decided_by == "friction map"
    assert lower < result.threshold < upper
    low, high = result.interval
    assert low <= result.threshold <= high
    assert 0 < result.std_error < 0.3 * result.threshold


def test_inertia_is_blind_to_friction_that_depends_on_speed_alone():
    result = found(swings(stribeck(5.0, 0.2)))
    assert result.sweep.values[1:30, 0] == pytest.approx(INERTIA, rel=0.02)
    assert result.from_map > 0.2
    assert np.ptp(result.sweep.values[:30, 1]) > 1.0  # while the Coulomb level moves


def test_inertia_sees_friction_with_memory():
    result = found(swings(bristles(1500.0)))
    assert abs(result.sweep.values[1, 0] - INERTIA) > 0.2
    fast = result.sweep.thresholds > 0.4
    assert result.sweep.values[fast, 0] == pytest.approx(INERTIA, rel=0.02)
    assert 0.1 < result.from_inertia < 0.4
    assert result.threshold >= result.from_inertia


def test_the_map_shows_the_friction_that_was_put_in():
    result = found(swings(stribeck(4.0, 0.1), noise=0.1))
    chart = result.map
    wanted = COULOMB + VISCOUS * chart.speed + 4.0 * np.exp(-((chart.speed / 0.1) ** 2))
    fine = chart.speed > 0.02
    assert chart.level[fine] == pytest.approx(wanted[fine], abs=0.2)
    assert chart.forward[fine] == pytest.approx(-chart.backward[fine], abs=0.3)


@pytest.mark.long
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in (1, 2))]
)
def test_gravity_fitted_or_subtracted_gives_the_same_answer(seed):
    robot = pendulum(mass=3.0)
    weight = 3.0 * 9.81 * 0.4
    runs = swings(stribeck(3.0, 0.1), gravity=weight, seed=seed)
    fitted = found(runs, "fitted", robot)
    subtracted = found(runs, "subtracted", robot)
    for result in (fitted, subtracted):
        assert result.sweep.values[10, 0] == pytest.approx(INERTIA, rel=0.05)
        assert 0.1 < result.threshold < 0.26
    assert "fitted along" in fitted.sentence
    assert "subtracted" in subtracted.sentence
    ignored = found(runs, "none", robot)
    assert abs(ignored.sweep.values[10, 0] - INERTIA) > 0.5


def test_a_sensors_bias_is_not_friction():
    runs = [replace(run, tau=run.tau + 2.0) for run in swings()]
    result = found(runs)
    assert result.threshold == 0.0
    assert result.sweep.values[5] == pytest.approx([INERTIA, COULOMB, VISCOUS], rel=0.01)


@pytest.mark.long
def test_bands_are_as_wide_as_estimates_scatter(pytestconfig):
    errors, values = [], []
    repeats = how_often(pytestconfig, 6, 12)
    for seed in range(repeats):
        sweep = found(swings(noise=2.0, seed=seed)).sweep
        errors.append(sweep.std_errors[20])
        values.append(sweep.values[20])
    ratio = np.std(values, axis=0) / np.mean(errors, axis=0)
    wider = np.sqrt(12 / repeats)
    assert np.all((ratio > 1 - 0.6 * wider) & (ratio < 1 + 0.5 * wider))


def test_what_is_told_comes_back_from_json_and_is_drawn():
    result = found(swings(stribeck(3.0, 0.1)))
    document = json.loads(json.dumps(plain(result.told()), allow_nan=False))
    told = parsed(ToldBoundary, document)
    assert told.joint == 1
    assert told.threshold == result.threshold
    assert told.sentence == result.sentence
    assert told.sweep.of("Fc").value == pytest.approx(tuple(result.sweep.values[:, 1]))
    assert told.friction_map.level == pytest.approx(tuple(result.map.level))
    assert plain(told) == document
    for figure in (convergence(told), friction_chart(told)):
        assert all(trace["type"] == "scatter" for trace in figure["data"])
    with pytest.raises(ValidationError, match="threshold"):
        parsed(ToldBoundary, {k: v for k, v in document.items() if k != "threshold"})


def test_what_cannot_be_judged_is_said():
    still = [Recording("still", run.t, 0 * run.q, run.tau) for run in swings()]
    with pytest.raises(UserError, match="still: joint 1 does not move"):
        found(still)
    with pytest.raises(UserError, match=r"\d whole swings, expected at least 6"):
        found([swings(cycles=(3, 1))[0]])


def test_another_joint_must_stand():
    from tests.trajectory.sample_arms import pa10

    run = swings()[0]
    q = np.zeros((len(run.t), 7))
    q[:, 1], q[:, 4] = run.q[:, 0], 0.1 * run.q[:, 0]
    both = Recording("both", run.t, q, np.zeros_like(q))
    with pytest.raises(UserError, match="both: joint 5 moves as well"):
        single_joint([both], pa10(), 1)


def test_a_neighbour_that_yields_a_little_is_taken_away():
    """The upper arm is shaken by 3 % of the elbow's speed at 5 Hz: the elbow feels it."""
    from tests.trajectory.sample_arms import pa10

    robot = pa10()
    runs = swings(stribeck(3.0, 0.1))
    t = runs[0].t
    q, dq, ddq = (np.zeros((len(t), 7)) for _ in range(3))
    omega = 2 * np.pi * 5.0
    size = 0.03 * 0.9 / omega
    q[:, 1] = size * np.sin(omega * t)
    dq[:, 2], ddq[:, 1] = size * omega * np.cos(omega * t), -size * omega**2 * np.sin(omega * t)
    q[:, 3] = runs[0].q[:, 0]
    dq[:, 3] = np.gradient(q[:, 3], t)
    ddq[:, 3] = np.gradient(dq[:, 3], t)
    own = runs[0].tau[:, 0] - INERTIA * ddq[:, 3]
    tau = inverse_dynamics(robot, robot.parameters, q, dq, ddq)
    tau[:, 3] += own
    shaken = single_joint([Recording("shaken", t, q, tau)], robot, 3, gravity="fitted")
    still = np.zeros(7)
    still[3] = 1.0
    calm_tau = inverse_dynamics(robot, robot.parameters, q * still, dq * still, ddq * still)
    calm_tau[:, 3] += own
    calm = single_joint([Recording("calm", t, q * still, calm_tau)], robot, 3, gravity="fitted")
    fast = np.abs(calm.speed) > 0.05
    assert np.std(tau[:, 3] - calm_tau[:, 3]) > 0.1
    assert np.std((shaken.tau - calm.tau)[fast]) < 0.02
