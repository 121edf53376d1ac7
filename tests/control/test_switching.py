"""Brakes open and close in ordinary cycles: watched, recorded, and open to commands."""

from __future__ import annotations

import socket

import numpy as np
import pytest
from arms import PERIOD, cycles, flywheel_arm, holding_arm, limits, servo, until

from backends.protocol import BackendFault
from pa10d.control.commands import Commands
from pa10d.control.loop import Loop
from pa10d.control.mailbox import Mailbox
from pa10d.control.states import ArmState
from pa10d.control.torque_exit import STANDING

ENABLING, DISABLING, RESETTING = ArmState.ENABLING, ArmState.DISABLING, ArmState.RESETTING
INACTIVE, HOLDING, FAULT = ArmState.INACTIVE, ArmState.HOLDING, ArmState.FAULT


def connected_arm():
    arm, backend = flywheel_arm()
    arm.connect()
    cycles(arm, 3)
    return arm, backend


def enabling_arm():
    """One whose second drive never says that it is enabled."""
    arm, backend = connected_arm()
    backend.stuck[1] = True
    arm.enable()
    cycles(arm, 20)
    assert arm.state == ENABLING
    return arm, backend


def test_a_wrong_sign_ends_before_the_joint_is_fast():
    """The other drive never says that it is enabled: nobody waits for it meanwhile."""
    arm, backend = connected_arm()
    backend.inverted[0] = backend.stuck[1] = True
    backend.plant.q[0] += 1e-4
    arm.enable()
    fastest = 0.0
    while arm.state != FAULT:
        arm.cycle()
        fastest = max(fastest, abs(backend.plant.dq[0]))
    assert (arm.fault.kind, arm.fault.axis) == ("wrong_sign", 0)
    assert "sign" in arm.fault.sentence
    assert not backend.powered
    # it grows as exp(97 t), 8 ms of persistence and 5 ms of filter and bus long
    assert fastest < 3.5 * STANDING * limits().velocity[0]
    assert abs(backend.plant.q[0]) < 0.05


def test_a_wrong_sign_is_found_before_the_arm_counts_as_held():
    arm, backend = connected_arm()
    backend.inverted[0] = True
    backend.plant.q[0] += 1e-5
    arm.enable()
    states = set()
    while arm.state != FAULT:
        arm.cycle()
        states.add(arm.state)
    assert HOLDING not in states
    assert arm.fault.kind == "wrong_sign"


def test_a_drive_that_never_enables_is_named():
    arm, backend = enabling_arm()
    until(arm, FAULT)
    assert (arm.fault.kind, arm.fault.axis) == ("timeout", 1)
    assert not backend.powered


def test_stop_while_enabling_is_obeyed():
    arm, backend = enabling_arm()
    arm.stop()
    until(arm, INACTIVE, seconds=0.1)
    assert not backend.powered
    assert arm.fault is None


def test_disable_while_enabling_is_obeyed():
    arm, backend = enabling_arm()
    arm.disable()
    until(arm, INACTIVE, seconds=0.1)
    assert not backend.powered


def test_a_closed_pipe_while_enabling_is_obeyed():
    """The loop itself, as the control process runs it."""
    arm, backend = connected_arm()
    backend.stuck[1] = True
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    loop = Loop(arm, arm.journal.ring, Commands(arm, None, servo), ours)
    arm.enable()
    theirs.close()
    loop.run()
    assert arm.state == ArmState.OFFLINE
    assert not backend.powered
    assert backend.time < 0.5  # it did not wait for the drive
    ours.close()


def test_commands_are_answered_while_enabling():
    arm, _ = connected_arm()
    arm.backend.stuck[1] = True
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    loop = Loop(arm, arm.journal.ring, Commands(arm, None, servo), ours)
    daemon = Mailbox(theirs)
    arm.enable()
    for number, do in enumerate(("alive", "stop", "end")):
        daemon.tell({"id": number, "do": do})
    loop.run()
    answers = [daemon.take() for _ in range(3)]
    assert {"reply": 1, "ok": True, "state": "disabling"} in answers
    ours.close()
    theirs.close()


@pytest.mark.parametrize("phase", [ENABLING, DISABLING, RESETTING])
def test_every_cycle_is_noted_down(phase):
    arm, backend = holding_arm() if phase == DISABLING else connected_arm()
    if phase == RESETTING:
        backend.fail["read"] = [BackendFault("joint 1: overcurrent", axis=0)]
        arm.cycle()
    {ENABLING: arm.enable, DISABLING: arm.disable, RESETTING: arm.reset}[phase]()
    began, before = arm.journal.count, backend.time
    while arm.state == phase:
        arm.cycle()
    assert arm.journal.count - began == round((backend.time - before) / PERIOD) >= 4
    rows, _ = arm.journal.ring.read(began)
    assert (arm.journal.ring.layout.get(rows, "state")[:-1] == phase).all()


def test_the_load_is_held_until_the_brakes_are_on():
    arm, backend = holding_arm()
    backend.plant.step, step = (
        lambda torque, dt: step(torque - 20.0, dt),
        backend.plant.step,
    )  # a weight
    cycles(arm, 500)
    held = backend.plant.q.copy()
    arm.disable()
    backend.written.clear()
    until(arm, INACTIVE)
    assert np.abs(np.array(backend.written[0]) - 20.0).max() < 0.5
    assert np.abs(backend.plant.q - held).max() < 1e-4


def test_a_push_while_disabling_is_noticed():
    arm, backend = holding_arm()
    arm.disable()
    backend.plant.q[0] += 0.3
    until(arm, FAULT)
    assert arm.fault.axis == 0
    assert not backend.powered


def test_drives_that_do_not_switch_off_get_no_torque_and_are_told_again():
    arm, backend = holding_arm()
    fault = BackendFault("joint 1: does not switch off", axis=0, kind="timeout")
    backend.fail["read"] = [fault]
    arm.disable()
    cycles(arm, 1)
    assert arm.state == FAULT
    assert arm.maybe_powered
    backend.written.clear()
    cycles(arm, 20)
    assert not np.any(backend.written)
    assert not backend.powered
    assert not arm.maybe_powered


def test_a_backend_that_never_ends_is_given_up():
    arm, backend = holding_arm()
    backend._switch = lambda: None
    arm.disable()
    until(arm, FAULT, seconds=20.0)
    assert arm.fault.kind == "switching"
    assert arm.maybe_powered


def late_arm():
    """A new control process on a clock that has run for long; its first look at the drives finds
    that the last process died."""
    arm, backend = flywheel_arm()
    backend.time = 1000.0
    backend.fail["read"] = [BackendFault("joint 1: heartbeat lost", axis=0)]
    arm.connect()
    assert arm.state == FAULT
    return arm, backend


def test_a_new_control_process_resets_drives_that_were_left_in_fault():
    """The 15 s that drives have began with the clock, and were over before the first cycle."""
    arm, _ = late_arm()
    arm.reset()
    until(arm, INACTIVE)
    assert arm.fault is None


def test_a_reset_after_an_hour_on_another_bus_has_its_time():
    arm, backend = connected_arm()
    arm.disconnect()
    backend.time += 3600.0
    backend.fail["read"] = [BackendFault("joint 1: heartbeat lost", axis=0)]
    arm.connect()
    arm.reset()
    until(arm, INACTIVE)


def test_a_reset_whose_drives_are_configured_for_long_has_its_time(monkeypatch):
    arm, backend = late_arm()
    begin = backend.begin_reset

    def slowly():
        begin()
        backend.time += 20.0

    monkeypatch.setattr(backend, "begin_reset", slowly)
    arm.reset()
    until(arm, INACTIVE)


def test_drives_of_a_new_control_process_that_never_switch_are_given_up():
    arm, backend = late_arm()
    backend._switch = lambda: None
    arm.reset()
    began = backend.time
    until(arm, FAULT, seconds=20.0)
    assert arm.fault.kind == "switching"
    assert 14.9 < backend.time - began < 15.1


def test_an_arm_that_is_enabled_after_its_errors_were_read_is_watched_for_its_signs():
    """Reading took so long that the first seconds of being held were over before they began."""
    arm, backend = connected_arm()

    def read_errors():
        backend.time += 20.0
        return []

    backend.read_errors, backend.clear_errors = read_errors, read_errors
    arm.drive_errors()
    backend.inverted[0] = True
    backend.plant.q[0] += 1e-5
    arm.enable()
    until(arm, FAULT)
    assert arm.fault.kind == "wrong_sign"


def test_a_reset_that_fails_says_why():
    arm, backend = connected_arm()
    backend.fail["read"] = [BackendFault("joint 1: overcurrent", axis=0)]
    arm.cycle()
    arm.reset()
    backend.fail["read"] = [BackendFault("joint 1: the cause persists", axis=0)]
    until(arm, FAULT)
    assert "persists" in arm.fault.sentence
    arm.reset()
    until(arm, INACTIVE)
    assert arm.fault is None


def test_drives_that_others_left_in_fault_are_reset_from_inactive():
    arm, backend = connected_arm()
    arm.reset()
    until(arm, INACTIVE)
    assert "reset" in backend.calls


def test_an_arm_that_is_enabled_at_once_is_held_where_it_stands():
    """Not where nobody has looked yet."""
    arm, backend = flywheel_arm()
    backend.plant.reset(np.array([0.7, -0.4]))
    arm.connect()
    arm.enable()
    until(arm, HOLDING)
    np.testing.assert_allclose(arm.path.reference.q, [0.7, -0.4], atol=1e-6)
