"""Figures of the error against what is known of the error that was put in."""

import json

import compare_arm as arm
import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.compare import compare, document, run_residual, scores


def test_a_known_sine_gives_its_own_figures():
    slow, fast = 2 * np.pi * 1.0, 2 * np.pi * 60.0

    def error(t, q, dq):
        return arm.on_joint(1, 3.0 * np.sin(slow * t) + 2.0 * np.sin(fast * t))

    run = run_residual(arm.model(), arm.recording(noise=0.0, extra=error))
    found = scores([run])
    assert found.rms[1] == pytest.approx(3.0 / np.sqrt(2), rel=0.02)
    assert found.max[1] == pytest.approx(3.0, rel=0.01)
    assert found.rms_raw[1] == pytest.approx(np.sqrt((9 + 4) / 2), rel=0.02)
    torque = run.measured[run.judged[:, 1], 1]
    assert found.nrmse[1] == pytest.approx(found.rms[1] / np.ptp(torque))
    explained = np.var(torque - run.error[run.judged[:, 1], 1]) / np.var(torque)
    assert found.r2[1] == pytest.approx(explained, abs=0.1)
    assert np.all(found.rms[[0, 2]] < 1e-9)


def test_filtering_equals_forward_backward_butterworth():
    import scipy.signal

    record = arm.recording(noise=1.0)
    run = run_residual(arm.model(), record)
    sos = scipy.signal.butter(4, arm.CUTOFF, fs=arm.RATE, output="sos")
    independent = scipy.signal.sosfiltfilt(sos, record.tau, axis=0)
    kept = run.decimated(independent)[20:-20]
    assert run.measured[20:-20] == pytest.approx(kept, abs=0.02)


def test_pooled_counts_every_sample_once():
    runs = [
        run_residual(arm.model(), arm.recording(seed, seconds, noise, name=f"r{seed}"))
        for seed, seconds, noise in ((1, 20.0, 0.5), (2, 60.0, 0.1))
    ]
    apart = [scores([run]).rms for run in runs]
    weight = np.array([run.judged.sum(axis=0) for run in runs])
    expected = np.sqrt(np.sum(weight * np.square(apart), axis=0) / weight.sum(axis=0))
    assert scores(runs).rms == pytest.approx(expected)


def test_a_resting_joint_is_judged_and_named():
    record = arm.recording()
    q = record.q.copy()
    q[:, 2] = 0.3
    still = type(record)("still", record.t, q, record.tau)
    found = compare(arm.model(), [still])
    assert np.all(np.isfinite(found.pooled.scores.rms))
    assert any("joint 3 hardly moves" in warning for warning in found.warnings)


def test_standstill_does_not_count():
    """Torque at rest may be anything between plus and minus stiction."""
    record = arm.recording(noise=0.0)
    q, tau = record.q.copy(), record.tau.copy()
    rest = slice(4000, 6000)
    q[rest] = q[4000]
    tau[rest] += 50.0
    paused = type(record)("paused", record.t, q, tau)
    counts = run_residual(arm.model(), paused).raw_counts
    assert not counts[4200:5800].any()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda r: type(r)(r.name, r.t, r.q[:, :2], r.tau[:, :2]), "has 2 joints, expected 3"),
        (lambda r: r.part(0, 60, ""), "too short for a cut-off of 10 Hz"),
    ],
)
def test_what_cannot_be_compared_is_one_line(change, words):
    with pytest.raises(UserError) as error:
        compare(arm.model(), [change(arm.recording(seconds=4.0))])
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_nothing_to_compare():
    with pytest.raises(UserError, match="at least one run"):
        compare(arm.model(), [])


def test_document_has_the_fixed_keys_and_is_strict_json():
    found = document(compare(arm.model(), [arm.recording(1, name="a"), arm.recording(2, name="b")]))
    again = json.loads(json.dumps(found, allow_nan=False))
    assert [run["name"] for run in again["runs"]] == ["a", "b"]
    for figures in (*again["runs"], again["pooled"]):
        for key in ("rms", "rms_raw", "nrmse", "max", "r2", "noise_floor"):
            assert len(figures[key]) == 3
            assert all(isinstance(value, float) for value in figures[key])
        assert figures["cutoff_hz"] == arm.CUTOFF
        assert isinstance(figures["where"], list)


def test_progress_goes_from_nothing_to_something():
    said = []
    compare(arm.model(), [arm.recording()], progress=lambda share, what: said.append(share))
    assert said == sorted(said)
    assert said[0] == 0.0
