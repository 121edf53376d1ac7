"""One motion under PID, feed-forward and computed torque on an arm that hides an effect: with the
same gains, what does the model leave, and what the improved one?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from arms import PERIOD, until
from fake_backend import FakeBackend

from backends.virtual.datasets import make_runs
from backends.virtual.plant import build
from pa10d.control.build import build_arm, servo_factory
from pa10d.control.computed_torque import BY_NAME, ComputedTorque, FeedForward
from pa10d.control.live_model import live_model
from pa10d.control.reference import MotionUnderWay, Reference
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState
from pa10d.diagnose.asked.adding import add_asked
from pa10d.dynamics import robot_from_profile
from pa10d.experiments.motion import rows_of, whole_motion
from pa10d.identify import identify
from pa10d.profile import load_profile
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.poses import Surroundings

SEED, JOINT = 3, 4
HIDDEN = ({"effect": "stribeck", "joint": JOINT, "Fs": 1.57, "vs": 0.136, "delta": 1.8},)
MOTION = {"kind": "tracking", "parameters": {"period": 4.0, "cycles": 1}}
START = np.array([0.0, 0.5, 0.0, 0.8, 0.0, 0.3, 0.0])


@pytest.fixture(scope="module")
def profile():
    return load_profile("pa10-sim")


@pytest.fixture(scope="module")
def robot(profile):
    return robot_from_profile(profile)


@pytest.fixture(scope="module")
def runs():
    """Other motions of an arm with masses of its own."""
    return list(make_runs(SEED, HIDDEN, kinds=("train_a", "train_b"), seconds=12.0)[0].values())


@pytest.fixture(scope="module")
def textbook(robot, runs):
    return identify(runs, robot, name="m0")


@pytest.fixture(scope="module")
def improved(textbook, runs):
    """With the effect."""
    return add_asked(textbook, "stribeck", [JOINT - 1], runs, name="m1")[0]


def tracking_rms(profile, robot, law=None, model=None):
    """(n,) rad on the arm that the models are of."""
    plant = build(profile, effects=HIDDEN, seed=9, dynamics={"spread": 0.2, "seed": SEED})
    plant.reset(START)
    ring = Ring.create(robot.n, 8192, PERIOD)
    arm = build_arm(profile, robot, FakeBackend(plant), ring)
    arm.connect()
    for _ in range(3):
        arm.cycle()
    arm.enable()
    until(arm, ArmState.HOLDING)
    for _ in range(500):
        arm.cycle()
    live = None if model is None else live_model(model)
    if live is not None:
        arm.use(BY_NAME[law](robot, live, servo_factory(profile, robot, PERIOD)()))
    plan = read_request(MOTION).build(Surroundings.of(robot))
    whole = whole_motion(plan, arm.path.reference.q.copy(), robot, 1.0 / PERIOD)
    began = ring.written
    arm.run(MotionUnderWay(1, rows_of(whole, model, live), whole.first, whole.last))
    while arm.state == ArmState.RUNNING:
        arm.cycle()
    assert arm.fault is None
    rows, _ = ring.read(began)
    rows = rows[ring.layout.get(rows, "recording") > 0]
    error = ring.layout.get(rows, "q_ref") - ring.layout.get(rows, "q")
    return np.sqrt(np.mean(error**2, axis=0))


@pytest.mark.long
def test_an_effect_in_the_model_more_than_halves_the_error_of_its_joint(
    profile, robot, textbook, improved
):
    pid, at = tracking_rms(profile, robot), JOINT - 1
    for law in BY_NAME:
        before, after = (tracking_rms(profile, robot, law, model) for model in (textbook, improved))
        assert np.all(before < 0.5 * pid)
        assert after[at] < 0.5 * before[at]
        others = np.delete(np.arange(robot.n), at)
        assert np.all(after[others] < 1.25 * before[others])


@pytest.mark.long
def test_feed_forward_looks_at_nothing_measured(profile, robot, textbook):
    """Its torque is that of the desired motion wherever the arm is; computed torque's is not."""
    rng, live = np.random.default_rng(2), live_model(textbook)
    reference = Reference(robot.n)
    reference.q[:], reference.dq[:], reference.ddq[:] = rng.normal(0.0, 0.3, (3, robot.n))
    near, far = rng.normal(0.0, 0.3, (2, robot.n))
    wanted = live.torque(
        robot, reference.q[None], reference.dq[None], reference.dq[None], reference.ddq[None]
    )[0]
    for law, looks in ((FeedForward, False), (ComputedTorque, True)):
        servo = servo_factory(profile, robot, PERIOD)()
        none = replace(servo.gains, kp=0 * servo.gains.kp, ki=0 * near, kd=0 * near)
        servo.gains = none
        made = law(robot, live, servo)
        torques = [made.torque(reference, q, near) for q in (near, far)]
        assert np.allclose(torques[0], torques[1]) != looks
        assert np.allclose(torques[0], wanted) != looks
