"""Every motion: derivatives that belong together, rest at both ends, a file and back."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.trajectory.limits import limits_of
from pa10d.trajectory.motions import (
    Chirp,
    Drawing,
    Fourier,
    Narrowed,
    Sines,
    Slowed,
    motion_from_dict,
    move_time,
    ramp_time,
)
from tests.trajectory.sample_arms import pa10

RNG = np.random.default_rng(0)


def drawing():
    strokes = Drawing(np.zeros(3))
    strokes.to(np.array([1.0, -0.5, 0.2]), 2.0)
    strokes.rest(0.5)
    window = strokes.cruise(np.array([0.1, 0.2, -0.3]), 3.0, 0.5)
    return strokes.knots(*window)


MOTIONS = {
    "fourier": Fourier(20.0, 1.5, 0.1, *RNG.normal(size=(1, 3)), *RNG.normal(size=(2, 5, 3))),
    "sines": Sines(8.0, 1.0, *RNG.normal(size=(2, 3)), np.array([0.1, 0.3, 0.5]), np.ones(3)),
    "chirp": Chirp(
        20.0, 2.0, np.zeros(3), np.array([0.2, 0.4, 0.0]), np.array([0.5, 0.6, 0.7]),
        np.array([2.0, 3.0, 4.0]), 0.2, 8.0,
    ),
    "knots": drawing(),
}  # fmt: skip
MOTIONS["slowed"] = Slowed(MOTIONS["sines"].to_dict(), 1.25)
MOTIONS["narrowed"] = Narrowed(drawing().to_dict(), np.array([1.0, 0.9, 0.5]), RNG.normal(size=3))


@pytest.mark.parametrize("name", MOTIONS)
def test_speeds_and_accelerations_are_derivatives(name):
    motion = MOTIONS[name]
    t = np.linspace(0.01, motion.duration - 0.01, 3001)
    h = 1e-5
    _, dq, ddq = motion.at(t)
    ahead, behind = motion.at(t + h), motion.at(t - h)
    assert dq == pytest.approx((ahead[0] - behind[0]) / (2 * h), abs=1e-6)
    slope = (ahead[1] - behind[1]) / (2 * h)
    off = np.abs(ddq - slope) > 1e-4 * (1 + np.abs(ddq))
    assert off.any(axis=1).mean() < 0.002  # a chirp begins to rise, knots join: jerk, at instants


@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_rests_at_both_ends_and_survives_a_file(name):
    motion = MOTIONS[name]
    samples = motion.sample(500.0)
    assert np.abs(samples.dq[[0, -1]]).max() < 1e-9
    assert samples.t[-1] == pytest.approx(motion.duration)
    again = motion_from_dict(json.loads(json.dumps(motion.to_dict())))
    assert np.array_equal(again.sample(77.0).q, motion.sample(77.0).q)
    assert again.steady == motion.steady


def test_the_steady_part_of_a_fourier_series_is_the_series_of_the_paper():
    motion = MOTIONS["fourier"]
    begin, end = motion.steady
    assert end - begin == pytest.approx(2 * motion.period)
    t = np.linspace(0.0, 20.0, 57)
    wanted = motion.centre + np.zeros((57, 3))
    for k in range(5):
        angle = 2 * np.pi * 0.1 * (k + 1) * t[:, None]
        wanted = wanted + motion.a[k] * np.sin(angle) - motion.b[k] * np.cos(angle)
    assert motion.at(begin + t)[0] == pytest.approx(wanted)


def test_no_pose_on_the_way_in_that_the_path_does_not_have():
    motion = MOTIONS["sines"]
    way = motion.at(np.linspace(0.0, motion.lead, 400))[0]
    path = motion.path(np.linspace(-2.0, 0.0, 4000))[0]
    distance = np.abs(way[:, None] - path[None]).max(axis=2).min(axis=1)
    assert distance.max() < 2e-3


def test_a_chirp_keeps_its_limits_and_reaches_both_frequencies():
    chirp = MOTIONS["chirp"]
    samples = chirp.sample(1000.0)
    assert np.all(np.abs(samples.q).max(axis=0) <= chirp.amplitude * 1.001)
    assert np.all(np.abs(samples.dq).max(axis=0) <= chirp.speed * 1.02)
    assert np.all(np.abs(samples.ddq).max(axis=0) <= chirp.acceleration * 1.02)
    assert np.all(samples.q[:, 2] == 0)
    begin, end = chirp.steady
    middle = np.linspace(end - 1.0, end, 200_001)
    q = chirp.at(middle)[0][:, 0]
    crossings = middle[1:][np.diff(np.sign(q)) != 0]
    assert 0.5 / np.diff(crossings)[-1] == pytest.approx(8.0, rel=0.02)
    omega = 2 * np.pi * 0.2
    size = (0.2**-4 + (omega / 0.5) ** 4 + (omega**2 / 2.0) ** 4) ** -0.25
    assert chirp.at(np.array([begin]))[1][0, 0] == pytest.approx(size * omega, rel=1e-6)


def test_a_lead_is_long_enough_for_the_acceleration_limit():
    limits = limits_of(pa10())
    fast = Sines(
        8.0, 1.0, np.zeros(7), np.array([0.6] + [0.0] * 6), np.full(7, 0.25), np.full(7, 0.3)
    )
    gentle = fast.gentle(limits)
    assert np.all(np.abs(gentle.sample(500.0).ddq) <= limits.acceleration * (1 + 1e-6))
    with pytest.raises(UserError, match="joint 1: the motion itself uses up the acceleration"):
        Sines(
            8.0, 1.0, np.zeros(7), np.array([0.6] + [0.0] * 6), np.full(7, 0.5), np.zeros(7)
        ).gentle(limits)


def test_move_and_ramp_times_use_up_a_limit_and_no_more():
    span, speed, rise = np.array([0.7, -1.2]), np.array([1.0, 1.0]), np.array([3.0, 3.0])
    strokes = Drawing(np.zeros(2))
    strokes.to(span, move_time(span, speed, rise))
    samples = strokes.knots().sample(4000.0)
    used = max(np.abs(samples.dq).max(), np.abs(samples.ddq).max() / 3.0)
    assert used == pytest.approx(1.0, abs=1e-3)
    strokes = Drawing(np.zeros(1))
    strokes.cruise(np.array([0.8]), 1.0, ramp_time(np.array([0.8]), np.array([3.0])))
    samples = strokes.knots().sample(4000.0)
    assert np.abs(samples.ddq).max() == pytest.approx(3.0, abs=1e-2)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"motion": "waltz"}, "found 'waltz', expected one of"),
        ({"extra": 1}, "expected exactly"),
        ({"centre": [1.0, "x"]}, "centre: expected rows of numbers"),
        ({"a": [[1.0, float("nan"), 0.0]] * 5}, "a: expected finite numbers"),
    ],
)
def test_a_broken_motion_is_one_clear_line(change, words):
    data = {**MOTIONS["fourier"].to_dict(), **change}
    with pytest.raises(UserError) as caught:
        motion_from_dict(data)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
