"""A delay is one for slow and fast parts of the motion; fast ones are believed otherwise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pa10d.checks import estimate_delay
from pa10d.dynamics import robot_from_urdf
from pa10d.identify import identify, timing
from pa10d.identify.timing import Shift, _agreed, _drawn
from pa10d.measurement.recording import Recording

URDF = """<robot name="pendulum"><link name="base"/>
<joint name="swing" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="50" velocity="10"/></joint>
<link name="rod"><inertial><mass value="2"/><origin xyz="0 0 -0.4"/>
<inertia ixx="0.03" iyy="0.03" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


def pendulum(seed: int, c3: float = 0.0) -> Recording:
    """A slow pendulum whose drive reads x where x - c3·x³ is there."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 40.0, 1 / 200)
    w = 2 * np.pi * rng.uniform(0.04, 0.4, 5)
    a, p = rng.uniform(0.2, 0.5, 5), rng.uniform(0, 6, 5)
    s = np.outer(t, w) + p
    q, dq, ddq = np.sin(s) @ a, np.cos(s) @ (a * w), -np.sin(s) @ (a * w**2)
    true = 0.35 * ddq + 7.848 * np.sin(q) + 0.8 * np.tanh(dq / 0.005) + 0.3 * dq
    read = true.copy()
    for _ in range(60):  # Newton's method
        read -= (read - c3 * read**3 - true) / (1 - 3 * c3 * read**2)
    read += rng.normal(0, 0.02, len(t))
    return Recording(t=t, q=q[:, None], tau=read[:, None], name=f"run{seed}")


def late(run: Recording, seconds: float) -> Recording:
    return replace(run, tau=np.interp(run.t - seconds, run.t, run.tau[:, 0])[:, None])


def in_a_loop(seed: int, bits: int, rate: float = 200.0, parts: int = 10) -> Recording:
    """The same pendulum behind a servo of 3 Hz that reads ``bits`` a turn and holds its torque for
    a sample: what is rounded comes back as torque."""
    rng = np.random.default_rng(seed)
    w = 2 * np.pi * rng.uniform(0.07, 0.8, 5)
    a, p = rng.uniform(0.1, 0.25, 5), rng.uniform(0, 6, 5)
    t = np.arange(0, 40.0, 1 / rate)
    s = np.outer(t, w) + p
    target, speed, more = np.sin(s) @ a, np.cos(s) @ (a * w), -np.sin(s) @ (a * w**2)
    ahead = 0.35 * more + 7.848 * np.sin(target) + 0.8 * np.tanh(speed / 0.05) + 0.3 * speed
    servo, step = 2 * np.pi * 3.0, 2 * np.pi / 2**bits
    read, tau = np.zeros(len(t)), np.zeros(len(t))
    q, dq, before, dt = target[0], speed[0], target[0], 1 / rate / parts
    for k in range(len(t)):
        read[k] = np.floor(q / step + 0.5) * step
        off = servo * (target[k] - read[k]) + 1.4 * (speed[k] - (read[k] - before) * rate)
        tau[k], before = ahead[k] + 0.6 * servo * off, read[k]
        for _ in range(parts):
            dq += dt / 0.35 * (tau[k] - 7.848 * np.sin(q) - 0.8 * np.tanh(dq / 0.005) - 0.3 * dq)
            q += dt * dq
    noisy = tau + rng.normal(0, 0.02, len(t))
    return Recording(t=t, q=read[:, None], tau=noisy[:, None], name=f"loop{seed}")


@pytest.mark.parametrize("bits", [20, 14, 13])
def test_what_a_servo_answers_to_its_encoder_is_no_delay(bits):
    """Torque acts half a sample after its angle: 2.5 ms, less half a step of this simulation."""
    model = identify([in_a_loop(1, bits)], robot_from_urdf(URDF), name="m", cutoff=10.0)
    assert model.shift == pytest.approx(-2.25e-3, abs=1e-3)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_delay_is_found(seed):
    model = identify([late(pendulum(seed), 8e-3)], robot_from_urdf(URDF), name="m", cutoff=10.0)
    assert model.shift == pytest.approx(8e-3, abs=1e-3)


def on_bristles(seed: int, way: float, seconds: float = 0.0, parts: int = 10) -> Recording:
    """The slow pendulum whose friction builds up over a way, dF/ds = (±level - F)/way (Dahl), and
    whose torque is read late."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 40.0, 1 / 200)
    w = 2 * np.pi * rng.uniform(0.04, 0.4, 5)
    a, p = rng.uniform(0.2, 0.5, 5), rng.uniform(0, 6, 5)
    fine = np.arange(parts * len(t)) / (200 * parts)
    s = np.outer(fine, w) + p
    q, dq, ddq = np.sin(s) @ a, np.cos(s) @ (a * w), -np.sin(s) @ (a * w**2)
    rubs, at = np.zeros(len(fine)), 0.0
    for k, step in enumerate(np.diff(q, prepend=q[0])):
        goal = 0.8 * np.sign(step)
        at = rubs[k] = goal + (at - goal) * np.exp(-abs(step) / way)
    true = 0.35 * ddq + 7.848 * np.sin(q) + rubs + 0.3 * dq
    read = np.interp(t - seconds, fine, true) + rng.normal(0, 0.005, len(t))
    return Recording(t=t, q=q[::parts, None], tau=read[:, None], name=f"bristles{seed}")


@pytest.mark.by_default("1-0.003", "2-0.0")
@pytest.mark.parametrize("seconds", [0.0, 3e-3])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_builds_up_over_a_way_is_no_delay(seed, seconds):
    """Behind a reversal such friction is late by as long as its way lasts."""
    run = on_bristles(seed, 0.02, seconds)
    model = identify([run], robot_from_urdf(URDF), name="m", cutoff=10.0)
    assert model.notes.shift.estimate_s == pytest.approx(seconds, abs=1e-3)
    checked = estimate_delay(run, robot_from_urdf(URDF))
    assert abs(checked.seconds - seconds) < 3.0 * checked.std_error + 2e-4


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5])
def test_a_saturation_hardly_poses_as_a_delay(seed):
    """The slow motion asks for 34 to 62 ms, by noise alone give or take 3 to 7; but far more is
    left over than noise."""
    model = identify([pendulum(seed, 1.25e-3)], robot_from_urdf(URDF), name="m", cutoff=10.0)
    told = model.notes.shift
    assert model.shift == 0.0
    assert abs(told.estimate_s) < 4.0 * told.std_error_s


@pytest.mark.parametrize("seed", [1, 3])
def test_a_delay_beside_what_the_model_lacks_is_taken(seed):
    """The saturation alone would pose as 3 to 6 ms; fast parts do not contradict that."""
    run = late(pendulum(seed, 1.25e-4), 8e-3)
    model = identify([run], robot_from_urdf(URDF), name="m", cutoff=10.0)
    assert model.shift == pytest.approx(8e-3, abs=7e-3)


def quick(seed: int, low: float = 0.0) -> Recording:
    """The same pendulum moved faster, so that noise knows its delay to 0.1 ms; low: N·m of Stribeck
    friction that no textbook has."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 40.0, 1 / 200)
    w = 2 * np.pi * rng.uniform(0.2, 1.2, 5)
    a, p = rng.uniform(0.1, 0.3, 5), rng.uniform(0, 6, 5)
    s = np.outer(t, w) + p
    q, dq, ddq = np.sin(s) @ a, np.cos(s) @ (a * w), -np.sin(s) @ (a * w**2)
    true = 0.35 * ddq + 7.848 * np.sin(q) + 0.8 * np.tanh(dq / 0.005) + 0.3 * dq
    read = true + low * np.exp(-(dq**2)) * np.sign(dq) + rng.normal(0, 0.02, len(t))
    return Recording(t=t, q=q[:, None], tau=read[:, None], name=f"quick{seed}")


@pytest.mark.parametrize("seed", [2, 3])
def test_what_one_stretch_alone_asks_for_is_no_delay(seed):
    """By noise alone it is known to 0.5 ms; by what is left over, to 2."""
    run = quick(seed)
    tau = run.tau.copy()
    tau[: len(tau) // 6] = late(run, 15e-3).tau[: len(tau) // 6]
    model = identify([replace(run, tau=tau)], robot_from_urdf(URDF), name="m", cutoff=10.0)
    told = model.notes.shift
    assert model.shift == 0.0
    assert 2e-3 < abs(told.estimate_s) < 1.05 * told.std_error_s


def test_angles_that_are_late_are_a_shift_where_that_is_sure():
    model = identify([late(quick(3), -8e-3)], robot_from_urdf(URDF), name="m", cutoff=10.0)
    assert model.shift == pytest.approx(-8e-3, abs=0.5e-3)


@pytest.mark.parametrize(
    ("milliseconds", "error", "taken"),
    [(-16.8, 4.76, False), (-16.8, 0.8, True), (-4.0, 1.0, True), (16.8, 2.0, True)],
)
def test_torque_that_is_early_has_to_be_known_better(monkeypatch, milliseconds, error, taken):
    """A sample is 5 ms: as early as that any logger may be."""
    seen = milliseconds * 1e-3 * np.ones(1)
    shift = Shift(
        0.0, float(seen[0]), error * 1e-3, seen, noise=error * 1e-3, errors=0.1 * np.abs(seen)
    )
    monkeypatch.setattr(timing, "_near_or_far", lambda heard: shift)
    monkeypatch.setattr(timing, "_differ", lambda one, other: False)
    model = identify([quick(3)], robot_from_urdf(URDF), name="m", cutoff=10.0)
    assert (model.shift != 0.0) is taken
    said = [w for w in model.notes.warnings if "as channels hardly are" in w]
    assert bool(said) is not taken


def test_what_all_stretches_lack_is_no_delay():
    """9 ms early, to 2 by noise and to 3 from stretch to stretch; but most is left over."""
    model = identify([quick(3, low=1.0)], robot_from_urdf(URDF), name="m", cutoff=10.0)
    assert model.shift == 0.0
    assert model.notes.shift.estimate_s < -5e-3


@pytest.mark.parametrize("seconds", [0.0, 4e-3])
def test_a_delay_of_all_stretches_is_known_as_well_as_noise_lets_it_be(seconds):
    model = identify([late(quick(1), seconds)], robot_from_urdf(URDF), name="m", cutoff=10.0)
    told = model.notes.shift
    assert abs(told.estimate_s - seconds) < 3.0 * told.std_error_s
    assert told.std_error_s < 0.2e-3


@pytest.mark.parametrize(
    ("own", "other", "drawn"),
    [
        ([0.7, -0.7, -0.3, -0.1, -0.4, -0.5], [2.1, -0.3, -0.3, -0.6, -1.3, -0.3], True),
        ([2.9, -2.9, 2.5, -2.5, 1.0, -1.0], [-2.9, 2.9, -2.5, 2.5, -1.0, 1.0], False),
    ],
)
def test_reversals_are_left_out_where_they_say_something_else(own, other, drawn):
    """3.6 ms apart, each known to half a millisecond by noise: what counts is by how much they
    differ from stretch to stretch."""
    near, far = (
        Shift(0.0, middle, 1e-3, np.array([middle]), noise=0.5e-3, without=middle + 1e-3 * rest)
        for middle, rest in ((-5.9e-3, np.array(own)), (-2.3e-3, np.array(other)))
    )
    assert _drawn(near, far) == drawn


@pytest.mark.parametrize(
    ("joints", "errors", "agreed"),
    [
        ([0.3, 6.2], [0.9, 0.3], False),  # of two, one is late by itself
        ([5.3, 6.2], [0.9, 0.3], True),
        ([5.4, 5.5, 0.0, 5.3, 5.6], [0.3] * 5, True),  # one of five is not late
        ([5.4, 0.0, 0.0, 0.1, 5.6], [0.3] * 5, False),
        ([5.4, -30.0, 40.0], [0.3, 20.0, 20.0], True),  # who knows nothing is no witness
        ([5.4, 9.0], [np.inf, np.inf], True),
    ],
)
def test_most_joints_that_know_have_to_agree(joints, errors, agreed):
    found = Shift(0.0, 5.4e-3, 0.5e-3, 1e-3 * np.array(joints), errors=1e-3 * np.array(errors))
    assert _agreed(found) == agreed


def test_a_low_pass_of_the_torque_is_a_delay():
    """A sensor's first order at 20 ms: its delay is that for slow motion, less for fast."""
    run = pendulum(1)
    tau, step = run.tau.copy(), 1.0 - np.exp(-5e-3 / 20e-3)
    for k in range(1, len(tau)):
        tau[k] = tau[k - 1] + step * (run.tau[k] - tau[k - 1])
    model = identify([replace(run, tau=tau)], robot_from_urdf(URDF), name="m", cutoff=10.0)
    assert 12e-3 < model.shift < 23e-3
