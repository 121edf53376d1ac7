"""Friction that wanders follows nothing that was recorded, but it turns round with the joint."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy
from two_links import COULOMB, RATE, V0, recordings, textbook

from pa10d.diagnose.procedure import diagnose
from pa10d.effects.base import smooth_sign
from pa10d.judgement import reversing, run_residual


def wandering(share: float, seconds: float, seed: int):
    """The first joint's dry friction wanders by itself: an Ornstein-Uhlenbeck process."""

    def extra(t, q, dq, ddq):
        rng = np.random.default_rng([seed, len(t), int(1e6 * abs(q[0, 0]))])
        pole = np.exp(-1.0 / (seconds * RATE))
        drive = share * np.sqrt(1.0 - pole**2) * rng.standard_normal(len(t))
        drive[0] = share * rng.standard_normal()
        level = COULOMB[0] * scipy.signal.lfilter([1.0], [1.0, -pole], drive)
        return np.column_stack([level * smooth_sign(dq[:, 0], V0), np.zeros(len(t))])

    return extra


def with_error(run, error):
    """The run with another error (N, n), N·m, before the low-pass."""
    filtered = run.equation.lowpass.of_torque(error)
    return replace(run, raw_error=error, measured=run.modelled + filtered)


@pytest.mark.long
def test_friction_that_wanders_is_no_noise():
    """ "none" at 7 times the floor: nothing came again, no motion foretold it, and size alone
    speaks from ten times on."""
    runs = recordings(5, wandering(0.05, 2.0, 1), 0.05)
    found = diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )
    assert found.verdict == "unknown"
    assert [u.joint for u in found.unexplained] == [0]
    assert "turns round with the joint" in found.remaining[0].sentence
    assert not found.remaining[1].significant


def swing(rng, samples, hertz=1.7):
    """(samples,) noise that swings: a lightly damped mode."""
    radius, angle = 0.995, 2 * np.pi * hertz / RATE
    return scipy.signal.lfilter(
        [1.0], [1.0, -2 * radius * np.cos(angle), radius**2], rng.standard_normal(samples)
    )


@pytest.mark.by_default("0.9995")
@pytest.mark.parametrize(
    "pole",
    [
        *(pytest.param(p, marks=pytest.mark.long) for p in (0.0, 0.9, 0.99)),
        0.9995,
        "swing",
        "friction",
    ],
)
def test_noise_does_not_know_which_way_a_joint_moves(pole):
    """Of any colour, and friction that is a little off is no wandering one: no smaller p than
    chance gives, by Kolmogorov and Smirnov."""
    runs = recordings(6)
    seen = [run_residual(textbook(runs), runs[name]) for name in ("valid_a", "valid_b")]
    rng = np.random.default_rng(7)
    said = []
    for _ in range(60):
        drawn = []
        for run in seen:
            noise = rng.standard_normal(run.raw_error.shape)
            if pole == "swing":
                noise = np.column_stack([swing(rng, len(noise)) for _ in range(2)])
            elif pole == "friction":
                noise += 3.0 * np.sign(run.seen.dq) + 5.0 * run.seen.dq
            else:
                noise = scipy.signal.lfilter([1.0], [1.0, -pole], noise, axis=0)
            drawn.append(with_error(run, noise))
        said += [one.p_value for one in reversing(drawn) if one is not None]
    assert len(said) > 30 or pole == "swing"
    if said:
        assert scipy.stats.kstest(said, "uniform", alternative="greater").pvalue > 0.01
