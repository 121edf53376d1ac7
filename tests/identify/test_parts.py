"""The steps of an identification, each on data made for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import estimates, fourier, pa10_truth, recording

from pa10d.common.errors import Cancelled, UserError
from pa10d.identify import condition_number, identify
from pa10d.identify.band import wide_enough
from pa10d.identify.cuts import cuts
from pa10d.measurement.motion import velocity_source
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass, delayed
from pa10d.regression.equation import prepare
from pa10d.regression.layout import textbook
from pa10d.regression.triangle import Triangle, left_over

RATE = 250.0


def noisy(truth, seconds=16.0, sigma=0.3, seed=0, rate=RATE):
    motion = fourier(truth.robot.n, seconds, rate)
    noise = sigma * np.random.default_rng(seed).normal(size=motion[1].shape)
    return recording(truth, motion, noise)


# ---- timing -------------------------------------------------------------------------------


@pytest.mark.by_default("-0.0035")
@pytest.mark.parametrize("seconds", [0.006, -0.0035])
def test_a_common_delay_is_found_and_taken_out(seconds):
    truth = pa10_truth(4)
    run = noisy(truth, 30.0)
    late = replace(run, tau=delayed(run.tau, seconds, RATE))
    model = identify([late], truth.robot, name="m", cutoff=10.0)
    assert model.shift == pytest.approx(seconds, abs=3e-4)
    in_time = identify([run], truth.robot, name="m", cutoff=10.0)
    assert np.all(model.noise < 1.05 * in_time.noise)
    assert any("torque is" in w and "ms" in w for w in model.notes.warnings)


def test_a_likely_delay_is_taken_though_it_is_not_proven():
    """Three standard errors: taken for zero it would turn friction round at the wrong time."""
    truth = pa10_truth(4)
    run = noisy(truth)
    late = replace(run, tau=delayed(run.tau, 7e-4, RATE))
    assert identify([late], truth.robot, name="m", cutoff=10.0).shift == pytest.approx(
        7e-4, abs=3e-4
    )


@pytest.mark.long
def test_no_delay_is_claimed_where_there_is_none():
    truth = pa10_truth(4)
    shifts = [
        identify([noisy(truth, seed=s)], truth.robot, name="m", cutoff=10.0).shift for s in range(6)
    ]
    assert shifts == [0.0] * 6


def test_one_late_joint_does_not_move_the_robot():
    truth = pa10_truth(4)
    run = noisy(truth, 30.0)
    tau = run.tau.copy()
    tau[:, 2:3] = delayed(run.tau[:, 2:3], 0.008, RATE)
    model = identify([replace(run, tau=tau)], truth.robot, name="m", cutoff=10.0)
    assert abs(model.shift) < 0.001


# ---- sharpness of the friction sign ----------------------------------------------------------


@pytest.mark.parametrize("v0", [0.003, 0.015])
def test_the_signs_sharpness_is_found_through_noise(v0):
    truth = pa10_truth(3, v0=v0)
    model = identify([noisy(truth, 30.0, sigma=0.05)], truth.robot, name="m", cutoff=15.0)
    found = np.array([t.shape["v0"] for t in model.terms if t.effect_id == "coulomb"])
    errors = np.array([t.shape_errors["v0"] for t in model.terms if t.effect_id == "coulomb"])
    assert np.all(np.abs(np.log(found / v0)) < np.log(1.5))
    assert np.all(errors < v0)


def test_without_friction_the_usual_sharpness_is_assumed_and_said():
    truth = pa10_truth(2, friction=False)
    model = identify([noisy(truth)], truth.robot, name="m", cutoff=10.0)
    assert {t.shape["v0"] for t in model.terms if t.effect_id == "coulomb"} == {0.01}
    assert any("not visible" in w for w in model.notes.warnings)


# ---- cut-off --------------------------------------------------------------------------------


def test_no_band_is_chosen_that_the_runs_are_too_short_for():
    """A coarse encoder asked for 1.8 Hz, of runs that are judged from 2.7 Hz on."""
    run = noisy(pa10_truth(3)).part(0, 1500, "")
    assert wide_enough([run], 2.7, 1.8) == 2.7


def test_the_chosen_cutoff_follows_the_noise():
    truth = pa10_truth(3)
    quiet, loud = (
        identify([noisy(truth, 24.0, sigma, rate=500.0)], truth.robot, name="m")
        for sigma in (0.05, 20.0)
    )
    assert loud.cutoff < quiet.cutoff <= 25.0
    assert loud.notes.cutoff.chosen_by == "torque falls to the noise"
    seen = [np.array(m.notes.cutoff.signal_hz) for m in (loud, quiet)]
    assert np.all(seen[0] <= seen[1])


@pytest.mark.long
def test_a_coarse_encoder_limits_the_cutoff():
    truth = pa10_truth(3)
    run = noisy(truth, 24.0, 0.02, rate=500.0)
    coarse = replace(run, q=np.round(run.q / 1e-3) * 1e-3)
    fine = identify([run], truth.robot, name="m").notes.cutoff
    rough = identify([coarse], truth.robot, name="m").notes.cutoff
    assert np.median(rough.encoder_hz) < 0.5 * np.median(fine.encoder_hz)
    assert rough.hertz < fine.hertz


def test_an_impossible_cutoff_is_refused():
    truth = pa10_truth(2)
    with pytest.raises(UserError, match=r"expected between .* and half the sampling rate"):
        identify([noisy(truth)], truth.robot, name="m", cutoff=200.0)


# ---- velocities ---------------------------------------------------------------------------


def test_a_reported_velocity_is_used_where_stamps_jitter():
    """Angles logged up to a millisecond late at known equal steps, velocities likewise."""
    truth = pa10_truth(2)
    t, q, dq, ddq = fourier(2, 20.0, 1000.0)
    late = np.random.default_rng(0).uniform(0, 2e-3, len(t))
    index = np.clip(np.round((t - late) * 1000).astype(int), 0, len(t) - 1)
    run = Recording("r", t, q[index], truth.torque(q, dq, ddq)[index], dq[index])
    assert velocity_source(run, 10.0).reported.all()
    with_it = identify([run], truth.robot, name="m", cutoff=10.0)
    without = identify([replace(run, dq=None)], truth.robot, name="m", cutoff=10.0)
    assert np.all(with_it.noise < 0.7 * without.noise)


def test_a_velocity_in_other_units_is_not():
    truth = pa10_truth(2)
    run = noisy(truth, rate=500.0)
    _, q, dq, _ = fourier(2, 16.0, 500.0)
    rough = q + 1e-3 * np.random.default_rng(1).normal(size=q.shape)
    assert velocity_source(replace(run, q=rough, dq=dq), 10.0).reported.all()
    assert not velocity_source(replace(run, q=rough, dq=np.degrees(dq)), 10.0).reported.any()
    assert not velocity_source(replace(run, q=q, dq=dq), 10.0).reported.any()  # no need


# ---- what is said ---------------------------------------------------------------------------


def test_a_joint_that_never_moves_is_named_with_the_remedy():
    truth = pa10_truth(3)
    t, q, dq, ddq = fourier(3, 16.0, RATE)
    for x in (q, dq, ddq):
        x[:, 1] = 0.0
    noise = 0.1 * np.random.default_rng(0).normal(size=q.shape)
    model = identify([recording(truth, (t, q, dq, ddq), noise)], truth.robot, name="m", cutoff=10.0)
    said = model.notes.warnings
    assert any("joint 2 (S2) hardly moves" in w and "move it over its range" in w for w in said)
    assert any("rank lost" in w for w in said)
    assert model.notes.rank < len(estimates(model))


def test_a_joint_that_turns_one_way_is_named():
    truth = pa10_truth(2)
    t = np.arange(4000) / RATE
    q = np.column_stack([0.3 * np.sin(t), 0.02 * t * t * np.sign(1)])
    dq = np.column_stack([0.3 * np.cos(t), 0.04 * t])
    ddq = np.column_stack([-0.3 * np.sin(t), np.full_like(t, 0.04)])
    model = identify([recording(truth, (t, q, dq, ddq))], truth.robot, name="m", cutoff=10.0)
    assert any("joint 2 (S2) turns round 0 times" in w for w in model.notes.warnings)


def test_with_torque_offset():
    truth = pa10_truth(3)
    run = noisy(truth)
    run = replace(run, tau=run.tau + np.array([1.0, 0.0, -2.0]))
    model = identify([run], truth.robot, name="m", cutoff=10.0, with_effects=["torque_offset"])
    found = {n: k for k, n in enumerate(model.parameter_names()) if "torque_offset" in n}
    values = estimates(model)[list(found.values())]
    errors = model.std_errors[list(found.values())]
    assert np.all(np.abs(values - [1.0, 0.0, -2.0]) < 4 * errors)
    assert np.all(errors < 0.5)
    assert len(model.parameter_names()) == len(model.covariance)


@pytest.mark.long
def test_an_effect_that_follows_the_load_sees_the_load():
    """Nothing is known of the load before a first fit: friction with it would have no columns."""
    truth, mu = pa10_truth(3), np.array([0.0, 0.10, 0.0])
    bare = replace(truth, rotor=0 * truth.rotor, coulomb=0 * mu, viscous=0 * mu)
    motion = fourier(3, 24.0, RATE)
    _, q, dq, ddq = motion
    rubs = mu * np.abs(bare.torque(q, dq, ddq)) * np.tanh(dq / truth.v0)
    noise = 0.05 * np.random.default_rng(1).normal(size=q.shape)
    run = recording(truth, motion, rubs + noise)
    model = identify([run], truth.robot, name="m", cutoff=10.0, with_effects=["load_friction"])
    found = [t for t in model.terms if t.effect_id == "load_friction"]
    assert float(found[1].coefficients[0]) == pytest.approx(mu[1], rel=0.05)
    plain = identify([run], truth.robot, name="m", cutoff=10.0)
    assert model.noise[1] < 0.2 * plain.noise[1]


def test_an_effect_with_a_shape_gets_the_best_of_its_starts():
    truth = pa10_truth(2)
    model = identify(
        [noisy(truth, 12.0)], truth.robot, name="m", cutoff=10.0, with_effects=["stribeck"]
    )
    assert all(t.shape for t in model.terms if t.effect_id == "stribeck")


def test_an_effect_is_told_of_one_joint():
    truth = pa10_truth(2)
    run = noisy(truth, 12.0)

    def told(*effects):
        model = identify([run], truth.robot, name="m", cutoff=10.0, with_effects=effects)
        return [(t.effect_id, t.joints) for t in model.terms if t.effect_id == "torque_offset"]

    assert told("torque_offset:2") == [("torque_offset", (1,))]
    assert told("torque_offset:2", "torque_offset") == [
        ("torque_offset", (1,)),
        ("torque_offset", (0,)),
    ]
    for wrong in ("torque_offset:3", "torque_offset:0", "torque_offset:", "torque_offset:x"):
        with pytest.raises(UserError, match=f"--with {wrong}: found joint .* expected 1 to 2"):
            told(wrong)
    with pytest.raises(UserError, match="acts on the whole robot, expected payload alone"):
        told("payload:2")


def test_refusals_in_words():
    truth = pa10_truth(2)
    run = noisy(truth, 8.0)
    with pytest.raises(UserError, match="no recording"):
        identify([], truth.robot, name="m")
    with pytest.raises(UserError, match="2 joints, expected 3"):
        identify([run], pa10_truth(3).robot, name="m")
    broken = run.tau.copy()
    broken[100, 1] = np.nan
    with pytest.raises(UserError, match=r"tau2 at 0\.4 s is not a number"):
        identify([replace(run, tau=broken)], truth.robot, name="m")
    with pytest.raises(UserError, match="too short for a cut-off of 10 Hz, expected at least"):
        identify([noisy(truth, 1.0)], truth.robot, name="m", cutoff=10.0)
    still = np.zeros_like(run.q)
    with pytest.raises(UserError, match="no joint moves"):
        identify([replace(run, q=still)], truth.robot, name="m")
    with pytest.raises(UserError, match="torque is zero throughout"):
        identify([replace(run, tau=still)], truth.robot, name="m")
    coarse = np.trunc(1.1 * np.sin(3.0 * run.t))[:, None] * [1.0, 2.0]
    with pytest.raises(UserError, match="no joint's torque is shown"):
        identify([replace(run, tau=coarse)], truth.robot, name="m")
    with pytest.raises(UserError, match="pair of joints"):
        identify([run], truth.robot, name="m", with_effects=["coupling_friction"])


def test_progress_is_told_and_cancelling_works():
    truth = pa10_truth(2)
    seen = []
    identify([noisy(truth, 8.0)], truth.robot, name="m", progress=lambda s, w: seen.append((s, w)))
    shares = [s for s, _ in seen]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    with pytest.raises(Cancelled):
        identify([noisy(truth, 8.0)], truth.robot, name="m", cancel=lambda: True)


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_the_unit_of_torque_does_not_matter(unit):
    truth = pa10_truth(2)
    run = noisy(truth, 12.0)
    plain = identify([run], truth.robot, name="m", cutoff=10.0)
    scaled = identify([replace(run, tau=unit * run.tau)], truth.robot, name="m", cutoff=10.0)
    np.testing.assert_allclose(estimates(scaled), unit * estimates(plain), rtol=1e-3)
    np.testing.assert_allclose(scaled.std_errors, unit * plain.std_errors, rtol=1e-2)


# ---- pieces and triangles ----------------------------------------------------------------------


@given(st.integers(300, 400_000), st.sampled_from([100.0, 250.0, 500.0]), st.floats(3.0, 20.0))
@settings(max_examples=40, deadline=None)
def test_pieces_count_every_sample_once(samples, rate, cutoff):
    from pa10d.regression.equation import decimation

    factor = decimation(rate, cutoff)
    counted = np.zeros(-(-samples // factor), dtype=int)
    for start, stop, first, last in cuts(samples, rate, cutoff):
        assert start % factor == 0
        assert stop <= samples
        counted[start // factor + first : start // factor + last] += 1
    assert np.all(counted == 1)


@given(st.integers(1, 400), st.integers(2, 8), st.integers(1, 5))
@settings(max_examples=30, deadline=None)
def test_a_triangle_keeps_all_norms(rows, width, parts):
    matrix = np.random.default_rng(rows).normal(size=(rows, width))
    triangle = Triangle(width)
    for part in np.array_split(matrix, parts):
        triangle.add(part)
    x = np.random.default_rng(width).normal(size=width)
    assert triangle.squares(x) == pytest.approx(float(np.sum((matrix @ x) ** 2)))
    assert triangle.rows == rows
    np.testing.assert_allclose(triangle.sums, matrix.sum(axis=0), atol=1e-9)


def test_left_over_is_what_other_columns_cannot_explain():
    rng = np.random.default_rng(2)
    known, rest = rng.normal(size=(50, 3)), rng.normal(size=(50, 2))
    triangle = Triangle(5)
    triangle.add(np.hstack([known, rest]))
    explained = known @ np.linalg.lstsq(known, rest, rcond=None)[0]
    left = left_over(triangle.r, 3)
    np.testing.assert_allclose(left.T @ left, (rest - explained).T @ (rest - explained))


def test_condition_number_is_that_of_the_stacked_matrix():
    truth = pa10_truth(3)
    _, q, dq, ddq = fourier(3, 8.0, 100.0)
    layout = textbook(truth.robot)
    from pa10d.dynamics import regressor

    rigid = regressor(truth.robot, q, dq, ddq, layout.base.kept)
    rotors = [t.joints[0] for t in layout.terms if t.effect.is_rotor]
    blocks = [rigid]
    for values in (ddq, 2 / np.pi * np.arctan(50 * dq), dq):
        block = np.zeros((len(q), 3, 3))
        block[:, range(3), range(3)] = values
        blocks.append(block[:, :, rotors] if values is ddq else block)
    matrix = np.concatenate(blocks, axis=2).reshape(3 * len(q), -1)
    assert matrix.shape[1] == layout.size
    found = condition_number(truth.robot, [(q, dq, ddq)])
    assert found == pytest.approx(np.linalg.cond(matrix), rel=1e-6)


# ---- the equation ---------------------------------------------------------------------------


def test_standing_joints_are_left_out_and_reversals_counted_apart():
    t = np.arange(5000) / 500.0
    q = np.column_stack([np.where(t < 5, np.sin(2 * t), np.sin(10.0)), np.sin(2 * t)])
    q[:, 0] = Lowpass(len(t), 500.0, 5.0)(q[:, 0])
    robot = pa10_truth(2).robot
    run = prepare(Recording("r", t, q, np.zeros_like(q)), robot, 10.0)
    late = (run.t > 6) & run.inside
    assert not run.moving[late, 0].any()
    assert run.moving[late, 1].mean() > 0.95
    assert 0.5 < run.keep[late, 1].mean() < run.moving[late, 1].mean()
    assert not run.inside[0]
    assert run.inside[len(run.t) // 2]


# ---- robust ----------------------------------------------------------------------------------


@pytest.mark.long
def test_knocks_do_not_drag_the_robust_fit_along():
    truth = pa10_truth(2)
    run = noisy(truth, 30.0)
    knocks = np.zeros_like(run.tau)
    for start in range(200, 7000, 700):
        knocks[start : start + 25] += 60.0
    struck = replace(run, tau=run.tau + knocks)

    def error(data, robust):
        model = identify([data], truth.robot, name="m", cutoff=10.0, robust=robust)
        clean = identify([run], truth.robot, name="m", cutoff=10.0)
        return np.abs((estimates(model) - truth.values(model)) / clean.std_errors)

    assert np.median(error(struck, True)) < 0.3 * np.median(error(struck, False))
    assert np.all(error(run, True) < 4.5)


def test_robust_errors_stay_honest_on_clean_data():
    truth = pa10_truth(2)
    run = noisy(truth, 30.0)
    plain, robust = (
        identify([run], truth.robot, name="m", cutoff=10.0, robust=r) for r in (False, True)
    )
    ratio = robust.std_errors / plain.std_errors
    assert np.all((ratio > 0.8) & (ratio < 1.3))
