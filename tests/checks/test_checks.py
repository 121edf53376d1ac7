"""Each flaw is put into a sound recording; exactly its finding must appear."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.checks import beyond_limits, check_recording, estimate_delay
from pa10d.checks.delay import check_delay
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.measurement.recording import Recording
from pa10d.measurement.sampling import analyse
from pa10d.measurement.spans import spans
from pa10d.profile import load_profile

RATE = 500.0
N = 10_000
LONG = pytest.mark.long


@pytest.fixture(scope="module")
def robot():
    return robot_from_profile(load_profile("pa10-sim"))


def _motion(t, seed=0):
    """Sums of three sines per joint, and their derivatives."""
    rng = np.random.default_rng(seed)
    q, dq, ddq = (np.zeros((len(t), 7)) for _ in range(3))
    for j in range(7):
        for f in (0.1, 0.23, 0.4):
            a, phase = rng.uniform(0.1, 0.25), rng.uniform(0, 6)
            w = 2 * np.pi * f
            q[:, j] += a * np.sin(w * t + phase)
            dq[:, j] += a * w * np.cos(w * t + phase)
            ddq[:, j] -= a * w**2 * np.sin(w * t + phase)
    return q, dq, ddq


def _sound(robot, late=0.0, seed=0, rubs=1.0):
    """A PA10 with friction, encoder steps and torque noise; its torque ``late`` seconds late."""
    rng = np.random.default_rng(100 + seed)
    t = np.arange(N) / RATE
    q, dq, _ = _motion(t, seed)
    then, dthen, ddthen = _motion(t - late, seed)
    scale = robot.effort / 232
    tau = inverse_dynamics(robot, robot.parameters, then, dthen, ddthen)
    tau += (
        rubs * scale * (8 * np.sign(dthen) + 10 * dthen) + rng.normal(size=tau.shape) * 0.3 * scale
    )
    q = np.round(q / 7.67e-6) * 7.67e-6
    return Recording("x", t, q, tau, dq)


def _but(recording, **changes):
    fields = {"t": recording.t, "q": recording.q, "tau": recording.tau, "dq": recording.dq}
    fields = {key: None if v is None else v.copy() for key, v in fields.items()}
    for key, change in changes.items():
        fields[key] = change(fields[key])
    return Recording("x", **fields)


def _codes(findings, joint=None):
    return {f.code for f in findings if f.severity != "info" and joint in (None, f.joint)}


def test_a_sound_recording_has_nothing_against_it(robot):
    recording = _sound(robot)
    findings = check_recording(recording, analyse(recording.t), robot)
    assert _codes(findings) == set()
    assert [f.code for f in findings] == ["rate", "delay"]
    assert "10000 samples at 500 Hz, 20.0 s, 7 joints" in findings[0].sentence


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=LONG)])
def test_friction_that_is_next_to_none_does_not_drive(robot, seed):
    """A sensor behind the gear sees none, and noise gives what is left of it either sign."""
    recording = _sound(robot, seed=seed, rubs=0.0)
    assert _codes(check_recording(recording, analyse(recording.t), robot)) == set()


def _joint(j, change):
    def apply(values):
        values[:, j] = change(values[:, j])
        return values

    return apply


def _hold(values):
    moving = values.copy()
    moving[4000:4200] = moving[4000]
    return moving


def _wrap(values):
    return (values * 8 + np.pi) % (2 * np.pi) - np.pi


FLAWS = {
    "clipped above": ({"tau": _joint(1, lambda v: np.minimum(v, 20.0))}, {"clipped"}, 2),
    "clipped below": ({"tau": _joint(3, lambda v: np.maximum(v, -10.0))}, {"clipped"}, 4),
    "frozen": ({"tau": _joint(2, _hold)}, {"frozen"}, 3),
    "constant": ({"tau": _joint(4, lambda v: 0 * v + 1.5)}, {"frozen"}, 5),
    "never moved": ({"q": _joint(6, lambda v: 0 * v + 0.3)}, {"never_moved"}, 7),
    "jump": ({"q": _joint(5, lambda v: v + 0.4 * (np.arange(N) > 6000))}, {"jump"}, 6),
    "degrees": ({"q": np.degrees}, {"degrees", "limits", "velocity_unit"}, None),
    "counts": ({"q": lambda q: np.round(q / 7.67e-6)}, {"counts", "limits", "velocity_unit"}, None),
    "speed in degrees": ({"dq": _joint(0, np.degrees)}, {"velocity_unit", "limits"}, 1),
    "speed reversed": ({"dq": _joint(0, lambda v: -v)}, {"velocity_unit"}, 1),
    "a clock that runs slow": ({"t": lambda t: t * 1.1}, {"clock"}, None),
    "a clock that runs fast": ({"t": lambda t: t * 0.96}, {"clock"}, None),
    "motor-side torque": ({"tau": lambda tau: tau / 50}, {"torque_small", "torque_scale"}, None),
    "millinewtonmetres": (
        {"tau": lambda tau: tau * 1e3},
        {"torque_large", "limits", "torque_scale"},
        None,
    ),
    "slow": ({"t": lambda t: t * 20}, {"slow"}, None),
    "milliseconds": ({"t": lambda t: t * 1000}, {"time_unit"}, None),
    "sign": ({"tau": _joint(2, lambda v: -v)}, {"turned"}, 3),
}


KIN = {
    "clipped below", "constant", "speed in degrees", "a clock that runs fast", "motor-side torque",
}  # fmt: skip
"""The same finding in another way, or (the last) one that ``test_geometry_checks`` has, too: with
--long."""
BY_TORQUE = ("millinewtonmetres", "sign")


@pytest.mark.by_default("jump", "degrees", "sign")
@pytest.mark.parametrize("case", [pytest.param(c, marks=LONG if c in KIN else ()) for c in FLAWS])
def test_a_flaw_is_named_at_its_joint(robot, case, request):
    """By default what a channel shows by itself is not looked for with the textbook's torque."""
    changes, wanted, joint = FLAWS[case]
    whole = case in BY_TORQUE or request.config.getoption("--long")
    findings = check_recording(_but(_sound(robot), **changes), None, robot, delay=whole)
    found = _codes(findings) if joint is None else _codes(findings, joint)
    ours = found - ({"velocity_unit"} if "q" in changes or "t" in changes else set())
    assert ours == wanted - ({"velocity_unit"} if "q" in changes or "t" in changes else set())
    if joint is not None:
        assert _codes([f for f in findings if f.joint not in (None, joint)]) <= {"limits"}
    gravest = [f.severity for f in findings]
    assert gravest == sorted(gravest, key=["error", "warning", "info"].index)
    assert all(f.sentence and "\n" not in f.sentence for f in findings)


def _dull(values):
    """What a coarse amplifier shows of a torque that is mostly below its first step."""
    return 0.0 + np.trunc(values / (0.8 * np.abs(values).max())) * 2.0


@pytest.mark.long
def test_a_channel_that_shows_next_to_nothing_is_no_lost_sensor(robot):
    """And says nothing against the other joints, which are looked at all the same."""
    changes = {"tau": lambda tau: _joint(2, lambda v: -v)(_joint(5, _dull)(tau))}
    found = check_recording(_but(_sound(robot), **changes), None, robot)
    told = [f for f in found if f.code in ("dull", "frozen")]
    assert [(f.code, f.joint, f.severity) for f in told] == [("dull", 6, "error")]
    assert "is exactly 0 N·m in" in told[0].sentence
    assert "steps are 2 N·m" in told[0].sentence
    assert "turned" in _codes(found, 3)


def test_a_few_bad_samples_make_a_fit_poorer_and_many_make_it_wrong(robot):
    def held(count):
        def apply(values):
            moving = values.copy()
            moving[4000 : 4000 + count] = moving[4000]
            return moving

        return {"tau": _joint(2, apply)}

    def severity(count):
        found = check_recording(_but(_sound(robot), **held(count)), None, robot, delay=False)
        return [f.severity for f in found if f.code == "frozen"]

    assert severity(int(0.008 * N)) == []  # shorter than a quarter of a second
    assert severity(int(0.013 * N)) == ["error"]
    few = _sound(robot)
    tau = few.tau.copy()
    top = np.sort(tau[:, 1])[-int(0.008 * N)]
    tau[:, 1] = np.minimum(tau[:, 1], top)
    found = check_recording(_but(few, tau=lambda _: tau), None, robot, delay=False)
    (clipped,) = [f for f in found if f.code == "clipped"]
    assert clipped.severity == "warning"


@pytest.mark.long
def test_a_motor_that_turns_on_and_on_is_not_in_degrees(shared_data):
    from pa10d.dynamics import robot_from_urdf
    from pa10d.store.csv_import import read_csv

    motor = robot_from_urdf(shared_data / "laas_motor/robot.urdf")
    found = read_csv(shared_data / "laas_motor/on.csv", motor.n, motor.name)
    s = found.samples
    findings = check_recording(Recording("on", found.timing.grid, s.q, s.tau, s.dq), None, motor)
    assert [f.severity for f in findings if f.code == "angle_unit"] == ["warning"]


def test_an_angle_that_starts_anew_every_turn(robot):
    recording = _but(_sound(robot), q=_joint(6, _wrap))
    found = check_recording(recording, None, None)
    assert not [f for f in found if f.code == "jump"]
    (jump,) = [f for f in found if f.code == "wrapped"]
    assert jump.advice == "--map 'q7[wrap2pi*rad]=q7'"
    assert jump.joint == 7


def test_a_coarse_sensor_is_not_clipped(robot):
    """Torque in steps of the drives' per mille dwells on its top level without being cut."""
    step = robot.effort / 1000
    recording = _but(_sound(robot), tau=lambda tau: np.round(tau / step) * step)
    assert "clipped" not in _codes(check_recording(recording, None, robot, delay=False))


def test_a_coarse_sensor_that_dwells_is_not_frozen(robot):
    """A slow torque stays at one of twenty levels for a quarter of a second. A lost sensor does
    not go on from there by one step."""
    sound = _sound(robot)
    step = 0.1 * np.abs(sound.tau).max(axis=0)
    coarse = np.round(sound.tau / step) * step
    same = np.diff(coarse, axis=0) == 0
    assert max(np.diff(spans(same[:, j])).max() for j in range(7)) > 0.25 * RATE
    found = check_recording(_but(sound, tau=lambda _: coarse), None, robot, delay=False)
    assert "frozen" not in _codes(found)
    held = coarse.copy()
    held[4000:4800, 1] = held[4000, 1]
    found = check_recording(_but(sound, tau=lambda _: held), None, robot, delay=False)
    assert "frozen" in _codes(found, 2)


def test_standing_still_is_neither_frozen_nor_clipped(robot):
    """A noise-free simulator holds exactly the same torque while the arm rests."""

    def rest(values):
        values[:3000] = values[3000]
        return values

    recording = _but(_sound(robot), q=rest, tau=rest, dq=rest)
    assert _codes(check_recording(recording, None, None)) == set()


def test_jitter_gaps_and_duplicates(robot):
    t = np.arange(N) / RATE
    late = t + np.random.default_rng(0).uniform(0, 0.5 / RATE, N)
    late[5000:] += 1.0
    findings = check_recording(_sound(robot), analyse(late, duplicates=3), robot, delay=False)
    assert _codes(findings) == {"jitter", "gaps", "duplicate_stamps"}
    (gap,) = [f for f in findings if f.code == "gaps"]
    assert "a gap without samples" in gap.sentence
    assert "that no fit and no judgement uses" in gap.sentence
    assert "at 9.99" in gap.sentence


def test_a_short_recording(robot):
    recording = _sound(robot).part(0, 1500, "")
    findings = check_recording(recording, None, robot)
    assert _codes(findings) == {"short"}
    assert "delay_unknown" in {f.code for f in findings}


def test_limits_are_said_with_joint_extent_and_share(robot):
    recording = _but(_sound(robot), q=_joint(1, lambda v: np.where(np.arange(N) < 100, 1.7, v)))
    (finding,) = beyond_limits(recording, robot)
    assert finding.joint == 2
    assert finding.sentence == (
        "joint 2 (S2): q reaches 1.7 rad, limits -1.588 … 1.588 (1 % of the samples are beyond)"
    )


@pytest.mark.long
@pytest.mark.parametrize(
    "late", [-0.004, *(pytest.param(late, marks=LONG) for late in (0.0, 0.0013, 0.007))]
)
def test_the_delay_is_found_within_its_interval(robot, late):
    """Below one sample as well; over several motions the stated interval holds."""
    hits, errors = 0, []
    for seed in range(4):
        delay = estimate_delay(_sound(robot, late, seed), robot)
        assert delay.known
        errors.append(delay.seconds - late)
        hits += abs(errors[-1]) < 3 * delay.std_error
        assert delay.std_error < 1e-3
    assert hits >= 3
    assert np.abs(errors).max() < 1.5e-3


def test_a_late_torque_is_a_warning(robot):
    (delay,) = check_delay(_sound(robot, late=0.012), robot)
    assert delay.code == "delay"
    assert delay.severity == "warning"
    assert "ms late against the position" in delay.sentence


@pytest.mark.long
def test_the_independent_simulator_s_torque_is_on_time(shared_data, robot):
    from pa10d.dynamics import robot_from_urdf
    from pa10d.store.csv_import import read_csv

    arm = robot_from_urdf(shared_data / "samples/robot.urdf")
    for name in ("train_a", "train_b", "valid_a"):
        found = read_csv(shared_data / f"samples/s01/{name}.csv.gz", 7, "arm")
        recording = Recording("x", found.timing.grid, found.samples.q, found.samples.tau)
        delay = estimate_delay(recording, arm)
        assert abs(delay.seconds) < 0.001
