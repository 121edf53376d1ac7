"""Old positions sent again are told; rest, coarse encoders and stick-slip are not."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.checks import check_recording
from pa10d.checks.held import check_held, held_runs
from pa10d.measurement.recording import Recording

T = np.arange(10_000) / 500.0


def smooth(noise: float = 1e-6) -> np.ndarray:
    rng = np.random.default_rng(1)
    return 0.5 * np.sin(1.7 * T) + 0.1 * np.sin(4.1 * T) + rng.normal(0, noise, len(T))


def held(q, *stretches):
    for first, count in stretches:
        q[first : first + count + 1] = q[first]
    return q


def recording(*joints):
    q = np.stack(joints, axis=1)
    tau = np.random.default_rng(2).normal(0, 1, q.shape)
    return Recording("r", T, q, tau)


def test_joint_place_and_length_are_said():
    (said,) = check_held(recording(smooth(), held(smooth(), (1000, 25))), None)
    assert (said.code, said.severity, said.joint) == ("held", "warning", 2)
    assert "joint 2: q repeats an old value for 25 samples (0.05 s) at 2.000 s" in said.sentence
    assert "leave these stretches out of a fit" in said.advice


def test_one_repeated_sample_of_a_moving_joint_is_found():
    assert held_runs(held(smooth(), (5000, 1), (7000, 1))) == [(5000, 1), (7000, 1)]


def test_a_joint_that_slows_down_meanwhile_is_found_too():
    q = held(smooth(), (350, 60))
    before, after = abs(q[350] - q[345]), abs(q[418] - q[413])
    assert max(before, after) > 2 * min(before, after)
    assert held_runs(q) == [(350, 60)]


def test_rows_sent_again_are_one_finding():
    (said,) = check_held(recording(*(held(smooth(), (1000, 300)) for _ in range(3))), None)
    assert said.severity == "error"
    assert said.sentence.startswith("joint 1, joint 2, joint 3: ")


def test_its_jump_is_not_told_twice():
    q = held(smooth(), (1000, 150))
    assert np.abs(np.diff(q)).max() > 0.05
    codes = [finding.code for finding in check_recording(recording(q), delay=False)]
    assert "held" in codes
    assert "jump" not in codes


def at_rest_between_motions():
    """Stops on a minimum-jerk ramp, stands, goes on."""
    s = np.clip((T % 5) / 2, 0, 1)
    return (T // 5) + 10 * s**3 - 15 * s**4 + 6 * s**5


def stick_slip():
    """Sticks for 40 ms, slips within two samples, again and again."""
    return 0.01 * (np.floor(T / 0.04) + np.clip((T % 0.04 - 0.036) / 0.004, 0, 1))


QUIET = {
    "rest": at_rest_between_motions(),
    "never moved": np.zeros(len(T)),
    "sticks and slips": stick_slip(),
    "coarse": np.round(smooth() / 0.01) * 0.01,
    "coarse and noisy": np.round(smooth(0.002) / 0.003) * 0.003,
    "coarse, other stamps": np.interp(
        T + 3e-4 * np.sin(900 * T), T, np.round(smooth() / 1e-3) * 1e-3
    ),
}


@pytest.mark.parametrize("what", QUIET)
def test_nothing_is_claimed_of(what):
    assert held_runs(QUIET[what]) == []


def test_false_words_are_rarer_than_promised():
    rng = np.random.default_rng(3)
    for _ in range(60):
        size, speed = rng.uniform(0.01, 1), rng.uniform(0.2, 8)
        q = size * np.sin(speed * T) + rng.normal(0, 10 ** rng.uniform(-7, -3), len(T))
        level = 10 ** rng.uniform(-6, -2)
        assert held_runs(np.round(q / level) * level) == []
