"""The arm's states, one torque exit, and every way to rest."""

from __future__ import annotations

import numpy as np
import pytest
from arms import PERIOD, cycles, flywheel_arm, holding_arm, limits, servo, swing, until

from backends.protocol import BackendFault
from pa10d.control.commands import Commands
from pa10d.control.reference import MotionUnderWay
from pa10d.control.states import ArmState, Refused
from pa10d.control.torque_exit import TorqueExit
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.profile import load_profile

HOLDING, RUNNING, STOPPING = ArmState.HOLDING, ArmState.RUNNING, ArmState.STOPPING
INACTIVE, FAULT, OFFLINE = ArmState.INACTIVE, ArmState.FAULT, ArmState.OFFLINE


def tail(arm, field, count=None):
    rows, _ = arm.journal.ring.read(0)
    values = arm.journal.ring.layout.get(rows, field)
    return values if count is None else values[-count:]


def test_inactive_only_reads():
    arm, backend = flywheel_arm()
    arm.connect()
    cycles(arm, 10)
    assert arm.state == INACTIVE
    assert set(backend.calls) == {"open", "read"}
    assert backend.written == []


def test_an_arm_that_is_not_powered_shall_be_where_it_is():
    """Clients saw a target of 0 and a tracking error of as much as the arm was turned."""
    arm, backend = flywheel_arm()
    backend.plant.q[:] = 0.3
    arm.connect()
    cycles(arm, 10)
    assert (tail(arm, "q_ref", 10) == tail(arm, "q", 10)).all()
    assert tail(arm, "q_ref")[-1] == pytest.approx(0.3)


def test_motion_is_followed_and_ends_held():
    arm, _ = holding_arm()
    arm.run(swing(arm.path.reference.q))
    until(arm, HOLDING)
    error = tail(arm, "q_ref") - tail(arm, "q")
    assert np.abs(error).max() < 0.02
    assert np.ptp(tail(arm, "q")) > 0.75  # it did move
    assert arm.fault is None


def test_only_the_recorded_part_is_marked():
    arm, _ = holding_arm()
    whole = swing(arm.path.reference.q)
    arm.run(MotionUnderWay(5, whole.rows, first=100, last=400))
    until(arm, HOLDING)
    marked = tail(arm, "row")[tail(arm, "recording") == 1]
    assert marked[0] == 101
    assert marked[-1] == 400
    assert len(marked) == 300


def test_stop_brakes_within_the_limits_and_holds():
    arm, _ = holding_arm()
    arm.run(swing(arm.path.reference.q))
    cycles(arm, 400)
    began = arm.journal.count
    arm.stop()
    until(arm, HOLDING)
    rows, _ = arm.journal.ring.read(began)
    speed = arm.journal.ring.layout.get(rows, "dq_ref")
    slowed = np.abs(np.diff(speed, axis=0)) / PERIOD
    assert slowed.max() <= limits().acceleration[0] * (1 + 1e-9)
    assert np.all(speed[-1] == 0)
    assert np.abs(arm.path.dq).max() < 0.05


def test_disable_while_running_rests_first():
    arm, backend = holding_arm()
    arm.run(swing(arm.path.reference.q))
    cycles(arm, 400)
    arm.disable()
    until(arm, INACTIVE)
    assert not backend.powered
    assert backend.plant.dq.max() == 0
    speeds = tail(arm, "dq")
    assert np.abs(speeds[-2]).max() < 0.05  # it rested before the brakes closed


def test_motion_from_elsewhere_is_refused():
    arm, _ = holding_arm()
    with pytest.raises(Refused, match=r"joint 1 at 0\.5"):
        arm.run(swing(arm.path.reference.q + 0.5))
    assert arm.state == HOLDING


@pytest.mark.parametrize("state", [OFFLINE, INACTIVE, FAULT])
def test_running_needs_holding(state):
    arm, backend = flywheel_arm()
    if state != OFFLINE:
        arm.connect()
        cycles(arm, 2)
    if state == FAULT:
        backend.fail["read"] = [BackendFault("bus off")]
        cycles(arm, 1)
    with pytest.raises(Refused) as refused:
        arm.run(swing(np.zeros(2)))
    assert refused.value.state == state
    assert refused.value.needed == (HOLDING,)
    assert refused.value.remedy


def test_axis_fault_stops_the_others_and_stays():
    arm, backend = holding_arm()
    arm.run(swing(arm.path.reference.q))
    cycles(arm, 400)
    backend.fail["read"] = [BackendFault("joint 2: overcurrent", axis=1, kind="drive_fault")]
    backend.written.clear()
    cycles(arm, 1)
    assert arm.state == STOPPING
    until(arm, FAULT)
    assert [t[1] for t in backend.written] == [0.0] * len(backend.written)
    assert any(t[0] != 0 for t in backend.written)  # joint 1 was braked by its motor
    assert not backend.powered
    assert arm.fault.document()["joint"] == 2
    cycles(arm, 50)
    for command in (arm.stop, arm.disable):
        command()
        assert arm.state == FAULT
    with pytest.raises(Refused):
        arm.enable()
    arm.reset()
    until(arm, INACTIVE)
    assert arm.fault is None


def test_what_a_fault_refuses_is_refused_by_its_name():
    arm, backend = holding_arm()
    arm.run(swing(arm.path.reference.q))
    cycles(arm, 400)
    backend.fail["read"] = [BackendFault("joint 2: overcurrent", axis=1, kind="drive_fault")]
    for state in (STOPPING, ArmState.DISABLING):
        until(arm, state)
        for command in (arm.run, arm.use):
            with pytest.raises(Refused, match="joint 2: overcurrent"):
                command(swing(arm.path.reference.q))


def test_a_stop_that_was_asked_for_is_waited_for():
    arm, _ = holding_arm()
    arm.run(swing(arm.path.reference.q))
    cycles(arm, 400)
    arm.stop()
    assert arm.state == STOPPING
    with pytest.raises(Refused, match="wait until the arm is at rest"):
        arm.run(swing(arm.path.reference.q))


def test_bus_fault_leaves_the_stop_to_the_drives():
    arm, backend = holding_arm()
    arm.run(swing(arm.path.reference.q))
    cycles(arm, 400)
    backend.fail["read"] = [BackendFault("bus off", kind="bus_error")]
    cycles(arm, 1)
    assert "quick_stop" in backend.calls
    backend.written.clear()
    until(arm, FAULT)
    assert not np.any(backend.written), "a torque of ours beside the drives' own stop"
    assert not backend.powered


def test_after_a_fault_motion_starts_where_the_arm_is():
    arm, backend = holding_arm()
    arm.run(swing(arm.path.reference.q))
    cycles(arm, 400)
    backend.fail["write"] = [BackendFault("bus off")]
    until(arm, FAULT)
    arm.reset()
    until(arm, INACTIVE)
    arm.enable()
    cycles(arm, 200)
    assert arm.state == HOLDING
    assert np.abs(arm.path.reference.q - backend.plant.q).max() < 0.01
    assert arm.motion is None


class Thrower:
    name = "thrower"

    def __init__(self, answer):
        self.answer, self.left = answer, 5

    def start(self, *_):
        pass

    def applied(self, *_):
        pass

    def torque(self, reference, q, dq):
        self.left -= 1
        if self.left > 0:
            return np.zeros(2)
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


@pytest.mark.parametrize(
    ("answer", "kind"),
    [
        (ZeroDivisionError("by nothing"), "controller"),
        (np.array([np.nan, 0.0]), "not_finite"),
        (np.array([0.0, np.inf]), "not_finite"),
    ],
)
def test_a_controller_that_fails_is_replaced_and_stopped(answer, kind):
    arm, backend = holding_arm()
    arm.use(Thrower(answer))
    backend.written.clear()
    until(arm, FAULT)
    assert arm.fault.kind == kind
    assert np.isfinite(backend.written).all()
    assert np.abs(backend.plant.q).max() < 0.05
    assert not backend.powered


def test_following_error_is_noticed():
    arm, backend = holding_arm()
    arm.run(swing(arm.path.reference.q))
    cycles(arm, 300)
    backend.plant.q[0] -= 0.2  # pushed away
    until(arm, FAULT)
    assert arm.fault.kind in ("following_error", "velocity_limit")
    assert arm.fault.axis == 0


def test_leaving_the_position_range_is_a_fault():
    arm, _ = holding_arm()
    far = swing(arm.path.reference.q, amplitude=3.0, seconds=8.0)
    with pytest.raises(Refused, match=r"joint 1 at .* beyond its upper limit of 2 rad"):
        arm.run(far)
    arm.motion, arm.state = far, RUNNING  # and should it ever get past that
    until(arm, FAULT, seconds=20)
    assert arm.fault.kind == "position_limit"
    assert np.abs(arm.path.q).max() < limits().upper[0] + 0.2


def test_axis_that_stops_answering_is_a_fault():
    arm, backend = holding_arm()
    backend.frozen[1] = True
    until(arm, FAULT)
    assert (arm.fault.kind, arm.fault.axis) == ("stale", 1)


def test_reversed_drive_does_not_run_away():
    arm, backend = holding_arm()
    step = backend.plant.step
    backend.plant.step = lambda torque, dt: step(-torque, dt)
    backend.plant.q[0] += 1e-3
    until(arm, FAULT)
    assert np.abs(backend.plant.q).max() < 0.5
    assert not backend.powered


def test_enabling_outside_the_limits_is_refused():
    arm, backend = flywheel_arm()
    backend.plant.reset(np.array([2.5, 0.0]))
    backend._q = backend.plant.q.copy()
    arm.connect()
    cycles(arm, 3)
    with pytest.raises(Refused, match=r"joint 1 stands 0\.5000 rad beyond"):
        arm.enable()
    assert not backend.powered


def test_failing_enable_leaves_the_drives_off():
    arm, backend = flywheel_arm()
    arm.connect()
    cycles(arm, 3)
    backend.fail["enable"] = [BackendFault("joint 2: timeout", axis=1)]
    arm.enable()
    until(arm, FAULT)
    assert "disable" in backend.calls
    assert not backend.powered


def test_exit_limits_torque_and_its_rate():
    path = TorqueExit(limits(), PERIOD)
    live = np.ones(2, dtype=bool)
    first = path.send(np.array([1e6, -1e6]), RUNNING, live)
    np.testing.assert_allclose(first, [10.0, -10.0])  # 5000 N·m/s for 2 ms
    for _ in range(20):
        last = path.send(np.array([1e6, -1e6]), RUNNING, live)
    np.testing.assert_allclose(last, [50.0, -50.0])


@pytest.mark.parametrize(("rate", "cycles"), [(1000.0, 8), (500.0, 4), (100.0, 2), (20.0, 2)])
def test_too_fast_is_a_matter_of_time(rate, cycles):
    """In a slow loop an arm that swings turns round before four cycles are over."""
    from pa10d.control.faults import LoopFault

    still, fresh = np.zeros(2), np.zeros(2, dtype=np.int64)
    fast = 1.3 * limits().velocity
    path = TorqueExit(limits(), 1.0 / rate)
    for _ in range(cycles - 1):
        path.watch(still, fast, fresh, still, np.ones(2, dtype=bool))
    with pytest.raises(LoopFault, match="more than it may"):
        path.watch(still, fast, fresh, still, np.ones(2, dtype=bool))


@pytest.mark.parametrize("state", [OFFLINE, INACTIVE, FAULT])
def test_exit_is_closed_outside_powered_states(state):
    from pa10d.control.faults import LoopFault

    path = TorqueExit(limits(), PERIOD)
    with pytest.raises(LoopFault):
        path.send(np.zeros(2), state, np.ones(2, dtype=bool))


def test_orphaned_arm_rests_and_is_latched():
    arm, backend = holding_arm()
    arm.run(swing(arm.path.reference.q))
    cycles(arm, 400)
    arm.emergency("daemon_gone", "the daemon is gone")
    until(arm, FAULT)
    assert arm.fault.kind == "daemon_gone"
    assert not backend.powered


@pytest.mark.by_default("3.0-3.5")
@pytest.mark.parametrize(("seconds", "held"), [(3.0, 3.5), (99.0, 11.0)])
def test_an_arm_that_sways_is_not_held_before_it_rests_or_has_had_its_time(seconds, held):
    """A motion that begins in a sway ends beside its path."""
    arm, backend = flywheel_arm(capacity=8192)
    arm.connect()
    cycles(arm, 3)
    arm.enable()
    began = arm.path.time
    while arm.state == ArmState.ENABLING:
        t = arm.path.time - began
        swings = t < seconds
        backend.plant.q[0] = 0.02 * np.sin(4.0 * t) if swings else 0.0
        backend.plant.dq[0] = 0.0
        arm.cycle()
    assert arm.state == ArmState.HOLDING
    assert min(seconds, 9.0) < arm.path.time - began < held


def test_an_arm_that_is_connected_with_felt_weights_is_held_by_them():
    robot = robot_from_profile(load_profile("pa10-sim"))
    arm, backend = flywheel_arm(robot.n)
    backend.plant.q[:] = 0.3
    felt = 2.0 * robot.parameters
    told = {"id": 1, "do": "connect", "bodies": felt.tolist()}
    assert Commands(arm, robot, lambda: servo(robot.n)).carry_out(told)["ok"]
    cycles(arm, 3)
    arm.enable()
    still = np.zeros((1, robot.n))
    weighs = inverse_dynamics(robot, felt, np.full((1, robot.n), 0.3), still, still)[0]
    np.testing.assert_allclose(arm.path.holding.thought, weighs)
    assert np.abs(weighs).max() > 10.0
