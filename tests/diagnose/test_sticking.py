"""What a joint does while it stands is nobody's error, however large its friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sticking import RATE, motion, sticking_runs
from two_links import recordings, state_of, textbook

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.search.harm import rms
from pa10d.judgement import judge, run_residual
from pa10d.measurement.standstill import stops

NOISE = 0.01  # N·m; friction is 20 and 10 N·m


def fit_and_held(runs):
    return [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]


def test_the_arm_stands_where_it_turns_round_and_its_derivatives_are_its_own():
    _, q, dq, ddq, _, stands = motion(1)
    assert 0.01 < stands.mean() < 0.3
    assert np.max(np.abs(np.gradient(q, 1 / RATE, axis=0) - dq)[5:-5]) < 2e-3
    assert np.mean(np.abs(np.gradient(dq, 1 / RATE, axis=0) - ddq)[5:-5]) < 0.02


@pytest.mark.by_default("5")
@pytest.mark.parametrize("seed", [2, 5])
def test_a_textbook_arm_that_sticks_is_identified_to_its_noise(seed):
    """Its error was 6 to 20 times the noise: the fit was bent by what it did while it stood."""
    runs = sticking_runs(seed, NOISE)
    _, held = fit_and_held(runs)
    model = textbook(runs)
    assert np.all(judge(model, held).ratio < 1.1)
    friction = {t.joints[0]: t.coefficients[0] for t in model.terms if t.effect_id == "coulomb"}
    assert friction[0] == pytest.approx(20.0, abs=0.01)
    assert friction[1] == pytest.approx(10.0, abs=0.01)


@pytest.mark.long
def test_what_it_does_while_it_stands_speaks_against_no_finding_either():
    """A torque that was 6.7 ms late, beyond doubt, was refused for what friction does at rest."""
    state = state_of(sticking_runs(3, NOISE))
    assert np.all(state.moving_rms() < 1.1 * rms(state.held_residual()))


@pytest.mark.long
def test_nothing_is_missing_on_an_arm_that_sticks():
    """It was "none" at 8 times the floor, or a Stribeck friction that nobody put in."""
    runs = sticking_runs(3, NOISE)
    found = diagnose(textbook(runs), *fit_and_held(runs))
    assert found.verdict == "none"
    assert np.all(found.left.ratio < 1.1)


@pytest.mark.long
def test_stribeck_friction_of_an_arm_that_sticks_has_its_own_size():
    """4.4 ± 1.0 N·m and 0.046 ± 0.016 rad/s had been found for 1.5 and 0.15, and a false one."""
    runs = sticking_runs(5, 2 * NOISE, lambda v: 1.5 * np.exp(-np.abs(v) / 0.15) * np.sign(v))
    found = diagnose(textbook(runs), *fit_and_held(runs))
    assert [(f.term.effect_id, f.term.joints) for f in found.findings] == [("stribeck", (0,))]
    values = found.findings[0].parameters
    for name, truth in (("Fs", 1.5), ("vs", 0.15), ("delta", 1.0)):
        assert values[name].value == pytest.approx(truth, abs=2.5 * values[name].std_error)
        assert values[name].std_error < 0.1 * truth
    assert np.all(found.left.ratio < 1.1)


@pytest.mark.long
def test_torque_of_a_standing_joint_is_in_no_equation_and_in_no_error():
    runs = recordings(6)
    model = textbook(runs)
    rng = np.random.default_rng(8)
    disturbed = {}
    for name, run in runs.items():
        tau = run.tau.copy()
        dq = run_residual(model, run).seen.dq
        for joint, found in enumerate(stops(dq, 200.0)):
            for start, stop in found:
                tau[start:stop, joint] += 500.0 * rng.uniform(-1.0, 1.0)
        disturbed[name] = replace(run, tau=tau)
    for plain, other in zip(
        two_sides(model, *fit_and_held(runs))[:2], two_sides(model, *fit_and_held(disturbed))[:2],
        strict=True,
    ):  # fmt: skip
        for j in range(2):
            assert other.tau[j] == pytest.approx(plain.tau[j], abs=1e-9)
    before, after = (judge(model, fit_and_held(of)[1]).rms for of in (runs, disturbed))
    assert after == pytest.approx(before, rel=1e-9)
