"""Set A and B, and feasibility by penalty, on an arm that is written down here."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import scipy.optimize

from pa10d.common.errors import UserError
from pa10d.dynamics import base_parameters, inverse_dynamics, regressor
from pa10d.dynamics.observation import model_columns
from pa10d.measurement.recording import Recording
from pa10d.paper.penalty import penalty_fit
from pa10d.paper.spans import steady_parts
from pa10d.paper.stack import least_squares, stacked
from pa10d.paper.variants import estimation_variants
from pa10d.regression.equation import prepare
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.motions import Fourier
from pa10d.trajectory.subarm import sub_arm
from tests.trajectory.sample_arms import around_pa10, pa10

COULOMB, VISCOUS = np.array([8.0, 4.0]), np.array([10.0, 5.0])
ROTOR = np.array([0.75, 0.21])


@cache
def arm():
    """Shoulder and elbow of the PA10."""
    return sub_arm(pa10(), np.array([1, 3]), np.zeros(7))


def recording(seed, slow_friction=0.0, noise=0.2, fundamental=0.1):
    rng = np.random.default_rng(seed)
    a, b = 0.35 * rng.normal(size=(2, 4, 2)) / np.arange(1, 5)[:, None]
    series = Fourier(20.0, 1.0, fundamental, np.array([0.1, 0.4]), a, b)
    t = np.arange(0.0, series.duration, 0.002)
    q, dq, ddq = series.at(t)
    tau = inverse_dynamics(arm(), arm().parameters, q, dq, ddq) + ROTOR * ddq
    tau += COULOMB * np.tanh(dq / 1e-3) + VISCOUS * dq
    tau += slow_friction * np.exp(-((dq / 0.08) ** 2)) * np.tanh(dq / 1e-3)
    return Recording(f"run {seed}", t, q, tau + noise * rng.normal(size=q.shape))


@cache
def equation(seed, slow_friction=0.0):
    return prepare(recording(seed, slow_friction), arm(), 8.0)


def test_the_stack_is_equation_9_row_by_row():
    stack = stacked([equation(1)], arm())
    run, columns = equation(1), model_columns(arm())
    rows = stack.rows[1]
    context = run.context
    whole = regressor(arm(), context.q, context.dq, context.ddq, columns.inertial)[:, 1]
    inside = run.inside
    b, r = len(columns.inertial), len(columns.rotor)
    assert rows[:, :b] == pytest.approx(run.lowpass(whole)[inside], abs=1e-9)
    assert rows[:, b + r + 3] == pytest.approx(run.lowpass(context.dq[:, 1])[inside], abs=1e-12)
    assert np.all(rows[:, b + r + 2] == 0)  # the viscous column of the other joint
    assert len(stack.tau[0]) == inside.sum()


def test_least_squares_find_what_was_put_in():
    stack = stacked([equation(1), equation(2)], arm())
    columns = model_columns(arm())
    b, r = len(columns.inertial), len(columns.rotor)
    for weighted in (False, True):
        h, sigma = least_squares(stack, weighted)
        assert h[b + r : b + r + 2] == pytest.approx(COULOMB, abs=0.1)
        assert h[b + r + 2 :] == pytest.approx(VISCOUS, abs=0.1)
        assert sigma == pytest.approx(stack.rms(h))
    rows, tau = stack.whole()
    plain = np.linalg.solve(rows.T @ rows, rows.T @ tau)
    assert least_squares(stack, weighted=False)[0] == pytest.approx(plain, rel=1e-5, abs=1e-6)


def variants(slow_friction):
    boundary = np.array([0.2, 0.2])
    return estimation_variants(
        [equation(1, slow_friction), equation(2, slow_friction)],
        [equation(3, slow_friction)], arm(), boundary,
    )  # fmt: skip


def test_fast_samples_alone_know_better_where_slow_friction_is_another():
    found = variants(4.0)
    a, b = (found.sets[name].ways["ols"].rms_above_boundary for name in "AB")
    assert np.all(a < 0.7 * b)
    assert all(0.2 < share < 0.9 for share in found.share_of_samples)
    assert found.sets["A"].samples[0] < found.sets["B"].samples[0]


def test_without_slow_friction_the_sets_agree():
    found = variants(0.0)
    a, b = (found.sets[name].ways["wls"].rms for name in "AB")
    assert a == pytest.approx(b, rel=0.1)
    for name in "AB":
        for way in ("ols", "wls", "penalty", "penalty_physical", "feasible"):
            assert found.sets[name].ways[way].rms == pytest.approx(b, rel=0.25)
        assert found.ours(name).feasible
        assert found.sets[name].ways["penalty_physical"].feasible
        assert found.sets[name].ways["ols"].feasible is None


def test_too_high_a_boundary_is_refused():
    with pytest.raises(UserError, match=r"set A: joint 1 has \d+ samples faster than 50 rad/s"):
        estimation_variants([equation(1)], [equation(3)], arm(), np.array([50.0, 0.1]))


def problem(seed=1, noise=1.0):
    """Few samples with much noise: least squares gives bodies that cannot exist."""
    stack = stacked([equation(seed)], arm())
    rng = np.random.default_rng(seed)
    rows, tau = stack.whole()
    some = rng.choice(len(tau), 60, replace=False)
    rows, tau = rows[some], tau[some] + noise * rng.normal(size=60)
    estimate = np.linalg.lstsq(rows, tau, rcond=None)[0]
    return rows, tau, estimate, base_parameters(arm())


@pytest.mark.parametrize("rule", ["paper", "physical"])
def test_penalised_parameters_obey_their_rule(rule):
    rows, tau, estimate, base = problem(noise=8.0)
    found = penalty_fit(rows, tau, estimate, base, arm().parameters, rule=rule)
    assert found.solved
    assert found.base[: len(base)] == pytest.approx(base.of(found.standard), abs=1e-6)
    for link in found.standard:
        tensor = link[np.array([[4, 5, 7], [5, 6, 8], [7, 8, 9]])]
        assert link[0] > 0
        assert np.linalg.eigvalsh(tensor)[0] > 0
    assert np.all(found.further > -1e-7)
    if rule == "physical":
        assert found.feasible


def test_positive_mass_and_inertia_do_not_make_a_body():
    """A long rod's moments with a centre of mass far outside: the paper's rule lets it pass."""
    seen = []
    for seed in range(1, 6):
        rows, tau, estimate, base = problem(seed, noise=8.0)
        seen.append(penalty_fit(rows, tau, estimate, base, arm().parameters).feasible)
    assert not all(seen)


def test_where_least_squares_is_feasible_the_penalty_changes_nothing():
    stack = stacked([equation(1), equation(2)], arm())
    rows, tau = stack.whole()
    base = base_parameters(arm())
    h, _ = least_squares(stack, weighted=False)
    found = penalty_fit(rows, tau, h, base, arm().parameters)
    assert found.base == pytest.approx(h, abs=0.05)
    assert found.cost == pytest.approx(float(np.linalg.norm(rows @ h - tau)), rel=1e-4)


@pytest.mark.long
def test_no_other_solver_finds_a_lower_cost():
    """Equation 17 minimised by a general optimiser from many starts, over Cholesky factors so that
    every point is allowed."""
    rows, tau, estimate, base = problem(noise=8.0)
    alpha = (1.0, 3.0)
    found = penalty_fit(rows, tau, estimate, base, arm().parameters, alpha)
    triangle = np.linalg.qr(np.column_stack([rows, tau]), mode="r")
    size = rows.shape[1] - len(base)

    def parameters(z):
        standard = np.empty((2, 10))
        for link in range(2):
            part = z[10 * link : 10 * link + 10]
            factor = np.zeros((3, 3))
            factor[np.tril_indices(3)] = part[4:]
            tensor = factor @ factor.T + 1e-4 * np.eye(3)
            standard[link, 0] = 1e-4 + part[0] ** 2
            standard[link, 1:4] = part[1:4]
            standard[link, 4:] = tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
        return np.concatenate([base.of(standard), z[20:] ** 2])

    def cost(z):
        x = parameters(z)
        return alpha[0] * np.linalg.norm(triangle[:, :-1] @ x - triangle[:, -1]) + alpha[
            1
        ] * np.linalg.norm(x - estimate)

    rng = np.random.default_rng(0)
    best = min(
        scipy.optimize.minimize(cost, rng.normal(size=20 + size), options={"maxiter": 400}).fun
        for _ in range(3)
    )
    assert found.cost <= best * (1 + 1e-3)
    assert found.cost > 0.9 * best


def test_a_recording_is_cut_into_what_its_plan_was_for():
    plan = read_request(
        {"kind": "boundary_velocity", "parameters": {"joints": [1], "cycles": 2, "slow_cycles": 1}}
    ).build(around_pa10())
    samples = plan.sample(100.0)
    run = Recording("run", samples.t + 5.0, samples.q, np.zeros_like(samples.q))
    parts = steady_parts(run, plan, begin=5.0)
    assert list(parts) == ["joint 1, fast", "joint 1, slow"]
    fast, slow = parts.values()
    assert fast.duration == pytest.approx(8.0, abs=0.03)
    assert slow.duration == pytest.approx(16.0, abs=0.03)
    assert np.abs(np.gradient(fast.q[:, 0], 0.01)).max() > 0.8
