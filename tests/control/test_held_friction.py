"""What a creeping joint's integral holds of its friction is let go as its motion brings its own."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest
from arms import holding_arm, swing
from hypothesis import given
from hypothesis import strategies as st

from pa10d.control.build import weight_of
from pa10d.control.commands import motion_of
from pa10d.control.gains import PidGains
from pa10d.control.held_friction import CREPT, LET_GO, SLIPS, HeldFriction
from pa10d.control.joint_figures import presumed_figures
from pa10d.control.known_joints import MeasuredJoints
from pa10d.control.messages import FollowRows
from pa10d.control.pid import Pid
from pa10d.dynamics import robot_from_profile
from pa10d.profile import load_profile
from pa10d.services.joints import learnt
from pa10d.services.prepared_motion import prepare_motion
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.poses import Surroundings

PERIOD = 0.004  # s
COULOMB = np.array([2.0, 0.5])  # N·m
STIFF = np.array([40.0, 10.0])  # N·m/rad
WAITS, MOVES = np.zeros(2, bool), np.ones(2, bool)
SLOW, FAST = np.full(2, 0.5 * SLIPS), np.array([0.5, 2.0]) * SLIPS


def let_go(way, dq=SLOW, coulomb=COULOMB, less=0.0):
    """(2,) N·m in all, of joints that crept ``way`` (2, rows) rad, stand while their torque falls
    by ``less`` (N·m), and then move."""
    held, torque = HeldFriction(coulomb, PERIOD, STIFF), 10.0 * np.ones(2)
    held.start(np.zeros(2), torque)
    for q in np.transpose(way):
        assert not held.let_go(q, dq, WAITS, torque).any(), "a joint that waits needs what it holds"
    for _ in range(50):
        torque = torque - less / 50
        held.let_go(q, 0.0 * dq, WAITS, torque)
    return sum(held.let_go(q, dq, MOVES, torque) for _ in range(round(20 * LET_GO / PERIOD)))


def test_all_of_it_goes_by_the_way_the_joint_crept():
    way = np.linspace(0.0, 3.0 * CREPT, 50) * np.array([[1.0], [-1.0]])
    assert let_go(way) == pytest.approx(COULOMB * [1.0, -1.0], rel=1e-6)
    assert let_go(0.3 * CREPT * np.ones((2, 1))) == pytest.approx(0.3 * COULOMB, rel=1e-6)


@pytest.mark.parametrize("share", [0.4, 1.0, 1.6])
def test_a_torque_that_fell_while_the_joint_stood_holds_less_of_it(share):
    """Friction balances the torque: what the servo takes back holds none any more."""
    way = np.linspace(0.0, 3.0 * CREPT, 50) * np.array([[1.0], [1.0]])
    assert let_go(way, less=share * COULOMB) == pytest.approx((1.0 - share) * COULOMB, abs=1e-6)


@given(
    way=st.lists(st.tuples(*2 * [st.floats(-5 * CREPT, 5 * CREPT)]), min_size=1, max_size=30),
)
def test_never_more_than_friction(way):
    assert (np.abs(let_go(np.transpose(way))) <= COULOMB * (1 + 1e-9)).all()


def test_a_slip_leaves_nothing_known():
    way = np.linspace(0.0, 3.0 * CREPT, 50) * np.ones((2, 1))
    assert let_go(way, FAST) == pytest.approx([COULOMB[0], 0.0], rel=1e-6)


def test_friction_that_was_not_measured_is_not_let_go():
    assert not HeldFriction(np.zeros(2), PERIOD, STIFF).known
    way = np.linspace(0.0, 3.0 * CREPT, 50) * np.ones((2, 1))
    assert let_go(way, coulomb=COULOMB * [1.0, 0.0])[1] == 0.0


@given(
    crept=st.floats(-3 * CREPT, 3 * CREPT),
    low=st.floats(-8.0, 8.0),
    wide=st.floats(0.0, 3.0),
)
def test_by_its_weight_no_more_than_must_be_and_no_less_than_can(crept, low, wide):
    """So that what is weight is not let go of; where a creep told as much, that stays."""
    held, torque, n = HeldFriction(COULOMB, PERIOD, STIFF), np.zeros(2), np.ones(2)
    held.start(np.zeros(2), torque)
    held.let_go(crept * n, SLOW, WAITS, torque)
    held.weighed(torque, low * n, (low + wide) * n)
    told = COULOMB * np.clip(crept / CREPT, -1.0, 1.0)
    gone = sum(
        held.let_go(crept * n, SLOW, MOVES, torque) for _ in range(round(20 * LET_GO / PERIOD))
    )
    wanted = np.clip(np.clip(told, -low - wide, -low), -COULOMB, COULOMB)
    assert gone == pytest.approx(wanted, abs=1e-6)


@pytest.mark.parametrize("share", [0.1, -0.4, 1.0])
def test_where_a_motion_waits_no_more_goes_than_its_torque_can_hold(share):
    """A gear creeps under next to nothing: it told all of its friction, pause after pause, and the
    joint was thrown by it. More than crept is none, either: weights are known where it began."""
    held, weighs = HeldFriction(COULOMB, PERIOD, STIFF), np.array([3.0, -1.0])
    held.start(np.zeros(2), weighs)
    held.weighed(weighs, weighs, weighs)
    held.let_go(np.zeros(2), SLOW, MOVES, weighs)
    torque = weighs + share * COULOMB
    held.let_go(np.zeros(2), SLOW, MOVES, torque)
    for q in np.linspace(0.0, 3.0 * CREPT, 50):
        held.let_go(np.array([q, 0.1 * q]), SLOW, WAITS, torque)
    cycles = range(round(20 * LET_GO / PERIOD))
    gone = sum(held.let_go(np.array([1.0, 0.1]) * 3.0 * CREPT, SLOW, MOVES, torque) for _ in cycles)
    most = max(share, 0.0)
    assert gone == pytest.approx(COULOMB * [most, min(most, 0.3)], abs=1e-6)


@pytest.mark.parametrize("of_gain", [0.1, 1.0, 10.0])
def test_what_creeps_while_its_torque_rises_does_not_slide(of_gain):
    """Friction that creeps from the first on took it all up: a milliradian told all of it, at a
    third of it, and the joint was thrown 0.15 rad by what was let go and was not there."""
    held, torque, q = HeldFriction(COULOMB, PERIOD, STIFF), np.zeros(2), 0.0
    held.start(np.zeros(2), torque)
    for k in range(500):
        q = 5e-5 * np.round(CREPT * k / 500 / 5e-5)  # steps of an encoder
        torque = torque + of_gain * STIFF * CREPT / 500
        assert not held.let_go(q * np.ones(2), SLOW, WAITS, torque).any()
    cycles = range(round(20 * LET_GO / PERIOD))
    gone = sum(held.let_go(q * np.ones(2), SLOW, MOVES, torque) for _ in cycles)
    slid = 1.0 / (1.0 + of_gain)
    took = of_gain * STIFF * CREPT / COULOMB
    assert (gone / COULOMB > 0.6 * slid).all()
    assert (gone / COULOMB < 1.4 * slid + took).all()


def test_a_joint_that_waits_while_others_move_holds_what_it_held():
    """A motion brings along what its weight changes by: that is no friction."""
    gains = PidGains(40.0 * np.ones(1), np.zeros(1), np.ones(1), friction=np.array([2.0]))
    servo, place, gone = Pid(gains, np.array([30.0]), PERIOD), np.zeros(1), 0.0

    def cycle(extra: float, q: float = 0.0, dq: float = 0.0, led: float = 0.0) -> float:
        """N·m sent."""
        at = SimpleNamespace(q=place, dq=np.array([led]), extra=np.array([extra]))
        wanted = servo.torque(at, place + q, place + dq)
        servo.applied(wanted, wanted)
        return float(wanted[0])

    still = SimpleNamespace(q=place, dq=place, extra=place)
    servo.start(still, place - 2.0 * CREPT, place, np.zeros(1))
    for q in np.linspace(-2.0 * CREPT, 0.0, 20):  # it creeps upwards
        cycle(0.0, q, 0.5 * SLIPS)
    for k in range(100):
        cycle(-0.05 * k)
    servo.absorb(np.array([-0.05 * 99]))
    held = cycle(0.0)
    for _ in range(round(20 * LET_GO / PERIOD)):
        gone = held - cycle(0.0, led=1e-9)
    assert gone == pytest.approx(2.0, rel=0.01)


def worst_of_a_stroke(
    friction: float, way: float, held: float = 0.0, weight: tuple[float, float] | None = None
) -> float:
    """rad: a joint creeps upwards to its place and is then sent by ``way``, its friction (2 N·m)
    and inertia brought along; the servo thinks of ``friction``. held: N·m, by which a joint that
    weighs 5 N·m is held with more as it stands in its place, and does not creep; weight: what of
    the 5 N·m is known."""
    inertia, dry, wet, seconds = 0.5, 2.0, 0.5, 1.0
    place, heavy = (0.0, 5.0) if held else (0.02, 0.0)
    gains = PidGains(np.array([40.0]), np.array([60.0]), np.array([6.0]))
    gains = PidGains(gains.kp, gains.ki, gains.kd, friction=np.array([friction]))
    servo, q, dq, worst = Pid(gains, np.array([30.0]), PERIOD), 0.0, 0.0, 0.0
    zero = SimpleNamespace(q=np.zeros(1), dq=np.zeros(1), extra=np.zeros(1))
    servo.start(zero, np.zeros(1), np.zeros(1), np.array([heavy + held]))
    for k in range(round(8.0 / PERIOD)):
        s = np.clip((k * PERIOD - 6.0) / seconds, 0.0, 1.0)
        run = way * 30.0 * (s**2 - 2 * s**3 + s**4) / seconds
        if weight is not None and s == 0.0:
            servo.weighed(*np.reshape(weight, (2, 1)))
        at = SimpleNamespace(
            q=np.array([place + way * (10 * s**3 - 15 * s**4 + 6 * s**5)]),
            dq=np.array([run]),
            extra=np.array([dry * np.sign(run) + wet * run]),
        )
        wanted = servo.torque(at, np.array([q]), np.array([dq]))
        servo.applied(wanted, wanted)
        torque = float(wanted[0]) - heavy
        for _ in range(8):
            h = PERIOD / 8
            free = (dq + h * torque / inertia) / (1 + h * wet / inertia)
            stop = h * dry / inertia / (1 + h * wet / inertia)
            dq = float(np.sign(free) * max(abs(free) - stop, 0.0))
            q += h * dq
        if s > 0.0:
            worst = max(worst, abs(q - float(at.q[0])))
    return worst


@pytest.mark.by_default("0.3")
@pytest.mark.parametrize("way", [0.3, -0.3])
def test_a_stroke_after_a_creep_keeps_to_its_path(way):
    assert worst_of_a_stroke(2.0, way) < 0.75 * worst_of_a_stroke(0.0, way)


@pytest.mark.by_default("-1.9-0.3")
@pytest.mark.parametrize("way", [0.3, -0.3])
@pytest.mark.parametrize("held", [1.9, -1.9])
def test_so_does_one_of_a_joint_whose_weight_is_known(way, held):
    """Nobody knows how it came to stand; what holds it beyond its weight is friction."""
    unknown, known, roughly = (
        worst_of_a_stroke(2.0, way, held, weight) for weight in (None, (5.0, 5.0), (4.7, 5.3))
    )
    assert max(known, roughly) < 0.7 * unknown


def test_what_an_arm_weighs_comes_with_its_motion(monkeypatch):
    arm, _ = holding_arm()
    told = []
    monkeypatch.setattr(Pid, "weighed", lambda _, *between: told.append(between))
    motion = swing(arm.path.reference.q)
    motion.weight = np.array([[1.0, 2.0], [3.0, 4.0]])
    arm.run(motion)
    assert np.array_equal(told, [motion.weight])


@pytest.mark.parametrize("weight", [((1.0,), (2.0,)), ((1.0, np.nan), (2.0, 3.0))])
def test_weights_that_are_none_of_this_arm_are_refused(weight):
    with pytest.raises(ValueError, match="2 joints weigh"):
        motion_of(FollowRows(1, -1, 0, 1, weight), 2)


def test_a_motion_is_prepared_with_all_that_the_arm_may_weigh(tmp_path):
    profile = load_profile("pa10-sim")
    robot = robot_from_profile(profile)
    bodies = robot.parameters * np.array([1.0, 1.2, 0.9])[:, None, None]
    known = learnt(profile, robot, presumed_figures(robot).but(bodies=bodies))
    asked = {"kind": "tracking", "parameters": {"joints": [6], "amplitude": 0.2, "period": 8.0}}
    plan = read_request(asked).build(Surroundings.of(robot))
    (tmp_path / "plan.json").write_text(json.dumps(plan.to_dict()), encoding="utf-8")
    joints = MeasuredJoints(known, "", (), "pa10", "f").document()
    start = plan.start.tolist()
    where = str(tmp_path), "pa10-sim", str(tmp_path), start, None
    weight = prepare_motion(*where, joints).motions[0].weight
    bare = weight_of(robot, robot.parameters)(plan.start)
    low, high = np.minimum(0.9 * bare, 1.2 * bare), np.maximum(0.9 * bare, 1.2 * bare)
    assert np.array(weight) == pytest.approx(np.array([low, high]))
    assert prepare_motion(*where, joints, ahead=False).motions[0].weight is None
