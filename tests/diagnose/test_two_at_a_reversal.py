"""Friction that is higher at low speed and builds up over a way: two effects that only together
make nothing worse where the joint turns round."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import scipy
from two_links import COULOMB, RATE, V0, recordings, textbook

from pa10d.diagnose.procedure import diagnose
from pa10d.effects.base import smooth_sign
from pa10d.judgement import run_residual, turning
from pa10d.measurement.standstill import stops

SUBSTEPS = 10


def lugre(t, q, dq, ddq, fs=4.0, vs=0.1, way=1e-3):
    """The first joint's friction in a bristle (fs N·m, vs rad/s, way rad): ż = v - |v|·z/zs(v),
    F = σ0·z (Canudas de Wit et al. 1995, without its dampings)."""
    speed = np.interp(np.arange(SUBSTEPS * len(t)) / SUBSTEPS, np.arange(len(t)), dq[:, 0])
    stiffness, step = COULOMB[0] / way, 1.0 / (RATE * SUBSTEPS)
    force, z = np.zeros(len(speed)), 0.0
    for k, v in enumerate(speed):
        level = COULOMB[0] + fs * np.exp(-((v / vs) ** 2))
        z = (z + step * v) / (1.0 + step * abs(v) * stiffness / level)
        force[k] = stiffness * z
    more = force[::SUBSTEPS] - COULOMB[0] * smooth_sign(dq[:, 0], V0)
    return np.column_stack([more, np.zeros(len(t))])


@pytest.mark.long
def test_stribeck_friction_of_a_bristle_is_named_with_the_bristle():
    """Stribeck friction alone made reversals worse and was refused, 18 times the floor stayed;
    beside a bristle that did not carry it its bump was half as high, and 7 times stayed."""
    runs = recordings(3, lugre, 0.02)
    found = diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )
    stribeck, bristle = found.findings
    assert (stribeck.term.effect_id, stribeck.term.joints) == ("stribeck", (0,))
    assert (bristle.term.effect_id, bristle.term.joints) == ("presliding_hysteresis", (0,))
    assert stribeck.parameters["Fs"].value == pytest.approx(4.0, rel=0.02)
    assert stribeck.parameters["vs"].value == pytest.approx(0.1, rel=0.01)
    assert bristle.parameters["F"].value == pytest.approx(COULOMB[0], rel=0.01)
    assert bristle.parameters["sigma0"].value == pytest.approx(COULOMB[0] / 1e-3, rel=0.02)
    assert max(line.ratio for line in found.remaining) < 1.1
    assert not found.unexplained


@pytest.mark.long
def test_what_is_there_only_after_reversals_is_no_noise():
    """Friction that is over soon after the joint has turned round: both parts are named, and what
    such short ones leave open is said."""
    runs = recordings(4, partial(lugre, fs=2.8, vs=0.05, way=5e-4), 0.02)
    found = diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )
    stribeck, bristle = found.findings
    assert (stribeck.term.effect_id, stribeck.term.joints) == ("stribeck", (0,))
    assert abs(stribeck.term.shape["vs"] - 0.05) < 2.0 * stribeck.parameters["vs"].std_error
    assert bristle.parameters["F"].value == pytest.approx(COULOMB[0], rel=0.01)
    assert found.remaining[0].material
    assert "the fitted runs do not determine the arm" in found.remaining[0].sentence
    assert not found.remaining[1].significant


@pytest.mark.long
@pytest.mark.by_default("0.99")
@pytest.mark.parametrize("pole", [0.0, 0.9, 0.99, 0.9995])
def test_noise_does_not_know_when_a_joint_turned_round(pole):
    """Of any colour: no smaller p than chance gives, by Kolmogorov and Smirnov."""
    runs = recordings(6)
    seen = [run_residual(textbook(runs), runs[name]) for name in ("valid_a", "valid_b")]
    rng = np.random.default_rng(7)
    said = []
    for _ in range(60):
        drawn = [
            with_error(run, scipy.signal.lfilter([1.0], [1.0, -pole], noise, axis=0))
            for run in seen
            for noise in [rng.standard_normal(run.raw_error.shape)]
        ]
        said += [one.p_value for one in turning(drawn) if one is not None]
    assert len(said) == 120
    assert scipy.stats.kstest(said, "uniform", alternative="greater").pvalue > 0.01


def test_what_a_joint_may_do_while_it_stands_is_no_error_after_it():
    """It sticks: friction of 500 times the noise is anything then, and the low-pass carries it."""
    runs = recordings(6)
    seen = [run_residual(textbook(runs), runs[name]) for name in ("valid_a", "valid_b")]
    rng = np.random.default_rng(8)
    drawn = []
    for run in seen:
        error = rng.standard_normal(run.raw_error.shape)
        for joint, found in enumerate(stops(run.seen.dq, RATE)):
            for start, stop in found:
                error[start:stop, joint] += 500.0 * rng.uniform(-1.0, 1.0)
        drawn.append(with_error(run, error))
    for one in turning(drawn):
        assert one.strokes > 12
        assert one.p_value > 0.01


def with_error(run, error):
    """The run with another error (N, n), N·m, before the low-pass."""
    filtered = run.equation.lowpass.of_torque(error)
    return replace(run, raw_error=error, measured=run.modelled + filtered)
