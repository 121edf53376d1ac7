"""Steps of an encoder become torque by an arm's inertia: noise that no spectrum above the band
shows, and that effects with the same derivatives take part of, on new data, too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from two_links import CUTOFF, motion, robot, textbook_torque

from pa10d.diagnose.procedure import diagnose
from pa10d.identify.procedure import identify
from pa10d.judgement import judge, run_residual
from pa10d.judgement.noise import ANGLES
from pa10d.measurement.recording import Recording


def recorded(name, seed, step, torque=textbook_torque, noise=0.003):
    """step: rad, of all angles; noise: N·m RMS of all torques."""
    rng = np.random.default_rng(seed)
    t, q, dq, ddq = motion(seed)
    tau = torque(q, dq, ddq) + noise * rng.standard_normal(q.shape)
    return Recording(name, t, np.round(q / step) * step, tau)


def told(step, torque=textbook_torque):
    runs = [recorded(name, seed, step, torque) for seed, name in enumerate("abc", 1)]
    model = identify(runs[:2], robot(), name="m0", cutoff=CUTOFF)
    return model, diagnose(model, runs[:2], runs[2:]), runs


@pytest.mark.long
def test_what_the_steps_make_is_noise():
    model, found, runs = told(1e-3)
    assert found.verdict == "none"
    assert "the angles' noise" in found.remaining[0].sentence
    floor = judge(model, runs[2:]).floor
    # the truth: the same motion and torque, with angles that have no steps
    exact = judge(model, [recorded("exact", 3, 1e-9)]).rms
    made = np.sqrt(judge(model, runs[2:]).rms ** 2 - exact**2)
    assert floor.methods == (ANGLES, ANGLES)
    assert floor.values == pytest.approx(np.hypot(made, 0.003 * np.sqrt(CUTOFF / 100.0)), rel=0.15)


@pytest.mark.long
def test_no_effect_is_made_of_noise():
    """Elasticity of joint 1 had taken 30 % of its squared error."""
    found = told(3e-3)[1]
    assert not found.findings
    assert found.verdict == "none"


@pytest.mark.long
def test_an_effect_is_seen_beside_the_steps():
    def sticking(q, dq, ddq):
        return textbook_torque(q, dq, ddq) + 1.5 * np.sign(dq) * np.exp(-np.abs(dq) / 0.15)

    found = told(1e-3, sticking)[1]
    assert "stribeck" in {one.term.effect_id for one in found.findings}


@pytest.mark.parametrize("of", ["held", "told"])
def test_a_joint_without_noise_of_its_angle_is_no_reason_to_fail(of):
    """One that stands behind its brake in the judged run, or whose own velocity is used."""
    runs = [recorded(name, seed, 1e-3) for seed, name in enumerate("abc", 1)]
    model = identify(runs[:2], robot(), name="m0", cutoff=CUTOFF)
    seen = run_residual(model, runs[2])
    angles = runs[2].q.copy()
    angles[:, 1] = 0.5 if of == "held" else np.nan
    made, errors = replace(seen, equation=replace(seen.equation, angles=angles)).of_angles
    assert made[0] == pytest.approx(seen.of_angles[0][0], rel=0.1)
    assert made[1] < seen.of_angles[0][1]  # of the other joint's noise alone
    assert np.all(np.isfinite(errors))


def test_what_moves_is_no_noise():
    """At 50 Hz exact angles had made seven times all that a good model leaves, so that nothing
    could be missing."""
    runs = []
    for seed, name in enumerate("ab", 1):
        t, q, dq, ddq = (x[::4] for x in motion(seed))
        noise = 1e-4 * np.random.default_rng(seed).standard_normal(q.shape)
        runs.append(Recording(name, t, q, textbook_torque(q, dq, ddq) + noise))
    seen = run_residual(identify(runs[:1], robot(), name="m0", cutoff=6.0), runs[1])
    left = np.array([np.std(x[on]) for x, on in zip(seen.error.T, seen.judged.T, strict=True)])
    assert np.all(seen.of_angles[0] < 0.2 * left)
