"""Control laws, gains, limits, estimator: against closed forms and independent routes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from arms import PERIOD, limits, until
from fake_backend import FakeBackend

from backends.virtual.plant import build
from pa10d.common.errors import UserError
from pa10d.control.build import build_arm, servo_factory
from pa10d.control.computed_torque import ComputedTorque
from pa10d.control.estimator import SpeedEstimator
from pa10d.control.gains import nominal_inertia, pid_gains
from pa10d.control.joint_figures import ROTOR
from pa10d.control.limits import arm_limits
from pa10d.control.live_model import LiveEffect, LiveModel, kinematics_of, live_model, remainder
from pa10d.control.pid import Pid
from pa10d.control.reference import Braking, MotionUnderWay, Reference
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState
from pa10d.dynamics import base_parameters, inverse_dynamics, robot_from_profile
from pa10d.effects import Context
from pa10d.model import ModelNotes, Term, TorqueModel
from pa10d.model.notes import FeasibleNote
from pa10d.profile import load_profile


@pytest.fixture(scope="module")
def profile():
    return load_profile("pa10-sim")


@pytest.fixture(scope="module")
def robot(profile):
    return robot_from_profile(profile)


def test_gain_rule_places_three_equal_poles(robot, profile):
    gains, inertia = pid_gains(robot, profile.control), nominal_inertia(robot)
    w = 2 * np.pi * profile.control.servo_bandwidth
    for j in range(robot.n):
        poles = np.roots([inertia[j], gains.kd[j], gains.kp[j], gains.ki[j]])
        np.testing.assert_allclose(poles, -w, rtol=1e-4)


@pytest.mark.parametrize("loop_rate", [20.0, 100.0, 250.0, 500.0, 1000.0])
@pytest.mark.parametrize("elbow", [0.0, 0.5, 1.5])
def test_no_pose_makes_the_servo_swing_up(robot, profile, elbow, loop_rate):
    """The loop as it is, with its filter and a cycle of delay, on rigid bodies and light rotors:
    a stretched arm is a quarter as heavy about its third joint as a bent one."""
    control, period = profile.control.model_copy(update={"rate": loop_rate}), 1.0 / loop_rate
    q = np.full((1, robot.n), 0.3)
    q[0, 3] = elbow
    still, weightless = np.zeros_like(q), robot.with_gravity(np.zeros(3))
    mass = np.stack(
        [inverse_dynamics(weightless, robot.parameters, q, still, unit[None])[0]
         for unit in np.eye(robot.n)]
    ) + np.diag(0.8 * ROTOR * robot.effort**1.75)  # fmt: skip
    law = Pid(pid_gains(robot, control), 1e6 * np.ones(robot.n), period)
    speed, rest = SpeedEstimator(robot.n, period), Reference(robot.n)
    angle, rate, sent = 1e-4 * np.ones(robot.n), np.zeros(robot.n), np.zeros(robot.n)
    for cycle in range(max(1000, int(2 * loop_rate))):
        speed.update(angle, np.zeros(robot.n, np.int64), cycle * period)
        wanted = law.torque(rest, angle, speed.dq)
        push = np.linalg.solve(mass, sent)
        angle = angle + period * rate + 0.5 * period**2 * push
        rate, sent = rate + period * push, wanted
    assert np.abs(angle).max() < 1e-6


def test_given_gains_are_taken(robot, profile):
    gains = profile.control.gains.model_copy(update={"kp": [float(k) for k in range(1, 8)]})
    control = profile.control.model_copy(update={"gains": gains})
    np.testing.assert_array_equal(pid_gains(robot, control).kp, np.arange(1.0, 8.0))


@pytest.mark.parametrize("factor", [1e-4, 40.0])
def test_a_torque_limit_of_another_motor_is_refused(profile, robot, factor):
    effort = robot.effort.copy()
    effort[2] *= factor
    with pytest.raises(UserError, match=r"limits\.torque\.3: found .* rated for, 100 N·m"):
        arm_limits(profile, replace(robot, effort=effort))


def test_an_arm_without_limits_is_not_moved(profile, robot):
    from dataclasses import replace

    with pytest.raises(UserError, match=r"limits\.acceleration: found nothing for joint 1"):
        arm_limits(profile, replace(robot, acceleration=np.full(7, np.inf)))


def test_braking_is_exact():
    reference = Reference(2)
    reference.dq[:] = [1.0, -0.3]
    braking = Braking(limits().acceleration, reference.dq.copy(), PERIOD)
    steps = 0
    while not braking.advance(reference):
        steps += 1
    np.testing.assert_allclose(reference.q, [1.0 / 8, -0.09 / 8], atol=1e-12)  # v²/2a
    assert steps == pytest.approx(0.25 / PERIOD, abs=1)


def test_integral_does_not_wind_up():
    """Pushed against a wall for long, then let go: the servo does not overshoot for as long."""
    from pa10d.control.gains import PidGains

    w = 2 * np.pi * 4.0 * np.ones(1)
    pid = Pid(PidGains(3 * w**2, w**3, 3 * w), np.array([10.0]), PERIOD)
    reference, q = Reference(1), np.zeros(1)
    reference.q[:] = 1.0
    for _ in range(5000):
        wanted = pid.torque(reference, q, np.zeros(1))
        pid.applied(wanted, np.clip(wanted, -10, 10))
    assert abs(pid._integral[0]) <= 10.0
    reference.q[:] = 0.0
    reached = 0
    for k in range(5000):  # the wall is gone; unit inertia
        wanted = pid.torque(reference, q, np.zeros(1))
        pid.applied(wanted, np.clip(wanted, -10, 10))
        reached = k
        if wanted[0] < 0.5:
            break
    assert reached * PERIOD < 0.5


def test_estimator_follows_a_ramp_over_missing_samples():
    rng = np.random.default_rng(1)
    estimator, speed = SpeedEstimator(2, PERIOD), np.array([0.7, -1.2])
    for k in range(400):
        age = rng.integers(0, 2, 2) if k > 10 else np.zeros(2, int)
        true = speed * k * PERIOD
        shown = np.where(age == 0, true, estimator._last)
        estimator.update(shown, age, k * PERIOD)
    np.testing.assert_allclose(estimator.dq, speed, rtol=0.02)


def test_a_late_cycle_is_no_fast_joint():
    estimator, speed, time = SpeedEstimator(1, PERIOD), 0.9, 0.0
    for k in range(300):
        time += 0.02 if k % 50 == 49 else PERIOD
        estimator.update(np.array([speed * time]), np.zeros(1, int), time)
        if k > 30:
            assert abs(estimator.dq[0] - speed) < 0.02


def test_several_answers_at_once_are_no_fast_joint():
    """They come in batches after a drive or a bus stood still: a period each, however many."""
    rng = np.random.default_rng(2)
    estimator, speed, shown, asked = SpeedEstimator(1, PERIOD), 0.9, 0, 0
    still = range(100, 180)
    for k in range(300):
        asked += 1
        came = 0 if k in still else min(asked - shown, int(rng.integers(1, 12)))
        shown += came
        age = np.array([0 if came else 1])
        estimator.update(np.array([speed * shown * PERIOD]), age, k * PERIOD, np.array([came]))
        if k > 30:
            assert estimator.dq[0] < speed + 0.02
    assert shown == asked
    assert abs(estimator.dq[0] - speed) < 0.02


def small_model(robot) -> TorqueModel:
    """Rigid bodies of the URDF with friction, a spring and a late torque sensor."""
    base = base_parameters(robot)
    terms = [Term("rotor_inertia", (1,), np.array([0.5]))]
    terms += [Term("coulomb", (j,), np.array([1.0 + j]), {"v0": 0.01}) for j in range(robot.n)]
    terms += [Term("viscous", (2,), np.array([3.0])), Term("torque_offset", (0,), np.array([2.0]))]
    terms += [Term("spring", (1,), np.array([5.0, 0.0]))]
    terms += [Term("torque_delay", (3,), np.array([0.01]))]
    size = len(base.kept) + sum(len(t.coefficients) for t in terms)
    relations = np.linalg.pinv(np.eye(10 * robot.n)[:, base.kept])
    h = relations @ _in_base(robot, base)
    return TorqueModel(
        "m", robot, base, h, tuple(terms), np.zeros((size, size)), np.zeros(robot.n), 20.0
    )


def _in_base(robot, base):
    """Standard parameters with the same torque, zero outside the base (least squares on Y)."""
    from pa10d.dynamics import regressor

    rng = np.random.default_rng(3)
    q, dq, ddq = rng.normal(size=(3, 60, robot.n))
    y = regressor(robot, q, dq, ddq).reshape(-1, 10 * robot.n)
    h, *_ = np.linalg.lstsq(y[:, base.kept], y @ robot.parameters.ravel(), rcond=None)
    out = np.zeros(10 * robot.n)
    out[base.kept] = h
    return out


def test_live_part_and_remainder_make_the_whole_prediction(robot):
    model = small_model(robot)
    t = np.arange(500) * PERIOD
    q = 0.4 * np.sin(2 * np.pi * 0.7 * t)[:, None] * np.ones(robot.n)
    dq, ddq = (
        np.gradient(q, PERIOD, axis=0),
        np.gradient(np.gradient(q, PERIOD, axis=0), PERIOD, axis=0),
    )
    live = live_model(model)
    total = live.torque(robot, q, dq, dq, ddq) + remainder(model, live, q, dq, ddq, PERIOD)
    context = Context(robot, t, q, dq, ddq, model.rigid, np.zeros_like(q))
    said = model.predict(context)
    delayed = Term("torque_delay", (3,), np.array([0.01])).torque(model.contextualise(context))
    np.testing.assert_allclose(total, said - delayed, atol=1e-9)
    assert np.abs(delayed).max() > 1e-3  # the sensor's delay is no torque to be commanded


def test_friction_of_a_desired_motion_changes_its_sign_where_the_motion_does(robot):
    """What is measured is noisy and smoothed, what is wanted is not: at low speed a soft sign would
    leave a joint stuck for a good part of a second after each reversal."""
    model = small_model(robot)
    rises = Term("stribeck", (1,), np.array([4.0]), {"vs": 0.15, "delta": 1.0})
    sticky = replace(model, terms=(*model.terms, rises))
    t = np.arange(int(12.0 / PERIOD)) * PERIOD
    q = 0.5 * np.cos(2 * np.pi / 40.0 * (t - 6.0))[:, None] * np.ones(robot.n)
    dq, ddq = (2 * np.pi / 40.0) * np.sqrt(np.maximum(0.25 - q**2, 0)), -((2 * np.pi / 40) ** 2) * q
    dq[t > 6.0] *= -1.0
    live = live_model(sticky)
    extra = [remainder(m, live, q, dq, ddq, PERIOD)[:, 1] for m in (sticky, model)]
    rise = extra[0] - extra[1]
    around = (np.abs(t - 6.0) > 0.1) & (np.abs(t - 6.0) < 0.5)
    assert np.all(np.abs(rise[around]) > 3.6)
    assert np.all(np.sign(rise[around]) == np.sign(6.0 - t[around]))


def test_the_loop_gets_bodies_that_can_exist_and_says_so(robot):
    """A free fit may have friction that pushes; live part and remainder are of one set."""
    model = small_model(robot)
    names = model.parameter_names()[len(model.h) :]
    found = dict.fromkeys(names, 0.25)
    possible = replace(
        model,
        standard=robot.parameters,
        feasible=True,
        notes=ModelNotes(feasible=FeasibleNote(rms=(0.0,) * robot.n, coefficients=found)),
    )
    assert live_model(model).parameters == "free"
    live = live_model(possible)
    assert live.parameters == "feasible"
    np.testing.assert_array_equal(live.rigid, robot.parameters)
    assert all(np.all(part.coefficients == 0.25) for part in live.parts)
    rng = np.random.default_rng(0)
    q, dq, ddq = rng.normal(0.0, 0.3, (3, 40, robot.n))
    total = live.torque(robot, q, dq, dq, ddq) + remainder(possible, live, q, dq, ddq, PERIOD)
    of_free = live_model(model).torque(robot, q, dq, dq, ddq) + remainder(
        model, live_model(model), q, dq, ddq, PERIOD
    )
    assert np.abs(total - of_free).max() > 0.1


def test_the_loops_friction_is_the_effects_own_formula(robot):
    """Each joint a sample of its own, whichever joints have the effect and however often."""
    model = small_model(robot)
    twice = Term("coulomb", (3,), np.array([1.5]), {"v0": 0.02})
    only = tuple(t for t in (*model.terms, twice) if t.effect.live and t.joints != (5,))
    model = replace(model, terms=only)
    rng = np.random.default_rng(1)
    q, dq, ddq = rng.normal(0.0, 0.3, (3, 30, robot.n))
    np.testing.assert_allclose(
        live_model(model).torque(robot, q, dq, dq, ddq), model.torque(q, dq, ddq), atol=1e-12
    )


def test_live_model_survives_the_pipe(robot):
    live = live_model(small_model(robot))
    again = LiveModel.from_document(live.document())
    np.testing.assert_array_equal(again.rigid, live.rigid)
    assert (again.name, again.parameters) == (live.name, live.parameters)
    assert len(again.parts) == len(live.parts) > 2
    for one, other in zip(again.parts, live.parts, strict=True):
        assert (one.effect_id, one.joints) == (other.effect_id, other.joints)
        np.testing.assert_array_equal(one.coefficients, other.coefficients)
        assert {k: v.tolist() for k, v in one.shape.items()} == {
            k: v.tolist() for k, v in other.shape.items()
        }


def test_computed_torque_tracks_better_than_pid_with_the_same_gains(profile, robot):
    """The paper's comparison (3.2.2): a sine of 30 degrees and 4 s on all joints."""
    plant = build(profile)
    book = plant.textbook
    errors = {}
    every = tuple(range(7))
    known = {"rotor_inertia": book.rotor_inertia, "coulomb": book.coulomb, "viscous": book.viscous}
    shapes = {"coulomb": {"v0": np.full(7, 0.002)}}
    parts = tuple(LiveEffect(k, every, v[:, None], shapes.get(k, {})) for k, v in known.items())
    live = LiveModel("known", robot.parameters, parts, kinematics=kinematics_of(robot))
    for name in ("pid", "computed_torque"):
        start = np.array([0.0, 0.5, 0.0, 0.8, 0.0, 0.3, 0.0])
        plant.reset(start)
        ring = Ring.create(7, 4096, PERIOD)
        arm = build_arm(profile, robot, FakeBackend(plant), ring)
        arm.connect()
        for _ in range(3):
            arm.cycle()
        arm.enable()
        until(arm, ArmState.HOLDING)
        if name == "computed_torque":
            arm.use(ComputedTorque(robot, live, servo_factory(profile, robot, PERIOD)()))
        for _ in range(200):
            arm.cycle()
        arm.run(sine(arm.path.reference.q))
        began = ring.written
        while arm.state == ArmState.RUNNING:
            arm.cycle()
        assert arm.fault is None
        rows, _ = ring.read(began)
        error = ring.layout.get(rows, "q_ref") - ring.layout.get(rows, "q")
        errors[name] = np.sqrt(np.mean(error**2, axis=0))
    assert np.all(errors["computed_torque"] < 0.5 * errors["pid"])


def sine(start, seconds=4.0):
    t = np.arange(int(seconds / PERIOD)) * PERIOD
    w, a = 2 * np.pi / seconds, np.deg2rad(30) / 2
    one = np.ones((1, len(start)))
    q = start + a * one * (1 - np.cos(w * t))[:, None]
    dq, ddq = a * w * one * np.sin(w * t)[:, None], a * w * w * one * np.cos(w * t)[:, None]
    return MotionUnderWay(1, np.hstack([q, dq, ddq, 0 * q]))


def test_simulated_time_gives_the_same_numbers_every_time(profile, robot):
    def torques():
        arm = build_arm(profile, robot, FakeBackend(build(profile)), Ring.create(7, 2048, PERIOD))
        arm.connect()
        for _ in range(3):
            arm.cycle()
        arm.enable()
        until(arm, ArmState.HOLDING)
        arm.run(sine(arm.path.reference.q))
        for _ in range(600):
            arm.cycle()
        return arm.journal.ring.layout.get(arm.journal.ring.read(0)[0], "torque")

    np.testing.assert_array_equal(torques(), torques())


def test_gravity_of_an_upright_arm(profile, robot):
    still = np.zeros((1, 7))
    assert np.abs(inverse_dynamics(robot, robot.parameters, still, still, still)).max() < 1e-9
