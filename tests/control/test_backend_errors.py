"""Whatever a backend throws, at whichever stage: the arm ends unpowered, and the reason is told.

``Loop`` and ``Commands`` are those of the control process; what they tell the daemon is looked at.
"""

from __future__ import annotations

import json
import logging
import re
import socket
from pathlib import Path

import numpy as np
import pytest
from arms import PERIOD, cycles, limits, servo, swing, until
from faulty_backend import THROWN, FaultyBackend

from backends.error_history import DriveErrors
from pa10d.control.arm import Arm
from pa10d.control.commands import Commands
from pa10d.control.journal import Journal
from pa10d.control.loop import Loop, describe
from pa10d.control.mailbox import Mailbox
from pa10d.control.ring import Ring
from pa10d.control.states import POWERED, ArmState

OFFLINE, INACTIVE, FAULT = ArmState.OFFLINE, ArmState.INACTIVE, ArmState.FAULT
TABLES = (Path(__file__).parents[2] / "docs" / "faults.md").read_text()
KINDS = {"device", *re.findall(r"^\| `(\w+)` \|", TABLES, re.MULTILINE)}
AT_LAST = 25.0  # s, more than any of the patience on the way to rest

STAGES = {  # the state in which a call breaks: who calls it
    "enable": ("enabling",),
    "read": ("inactive", "enabling", "holding", "running", "stopping", "disabling", "resetting"),
    "write": ("enabling", "holding", "running", "stopping", "disabling", "resetting"),
    "switching": ("enabling", "disabling", "resetting"),
    "disable": ("disabling",),
    "reset": ("resetting",),
}


@pytest.fixture(autouse=True)
def quiet():
    log = logging.getLogger("pa10d.control")
    log.disabled = True
    yield
    log.disabled = False


def arm_on(backend: FaultyBackend) -> Arm:
    ring = Ring.create(2, 4096, PERIOD)
    return Arm(backend, limits(), servo, lambda q: np.zeros(2), Journal(ring))


def brought_to(state: str) -> tuple[Arm, FaultyBackend]:
    """An arm that is about to be in this state: the next call of the backend belongs to it."""
    backend = FaultyBackend()
    arm = arm_on(backend)
    arm.connect()
    cycles(arm, 3)
    if state == "resetting":
        backend.once["read"] = THROWN["a fault of one axis"]
        cycles(arm, 2)
        assert arm.state == FAULT
    if state in ("holding", "running", "stopping", "disabling"):
        arm.enable()
        until(arm, ArmState.HOLDING)
    if state in ("running", "stopping"):
        arm.run(swing(arm.path.reference.q))
        cycles(arm, 300)
    return arm, backend


def enter(arm: Arm, state: str) -> None:
    do = {"enabling": arm.enable, "stopping": arm.stop, "disabling": arm.disable,
          "resetting": arm.reset}  # fmt: skip
    if state in do:
        do[state]()


def wait_for_its_end(arm: Arm) -> None:
    for _ in range(int(AT_LAST / PERIOD)):
        if arm.state in (FAULT, INACTIVE) and not arm.backend.switching_now:
            return
        arm.cycle()
    raise AssertionError(f"{arm.state.label} for ever: {arm.fault}")


FaultyBackend.switching_now = property(lambda self: self._left > 0)


def assert_told(arm: Arm, thrown: str) -> None:
    """What clients are told of it: the cause, the joint as far as it is known, what to do."""
    told = json.loads(json.dumps(describe(arm).document()))
    fault = told["fault"]
    assert told["state"] == "fault"
    assert fault == arm.journal.ring.said(), "who records the run reads the same"
    assert fault["kind"] in KINDS
    assert fault["remedy"] in fault["sentence"]
    assert len(fault["sentence"]) < 5000
    wrong = THROWN[thrown]()
    words = str(wrong.args[0]) if wrong.args else type(wrong).__name__
    assert words[:5] in fault["sentence"]
    joint = 2 if getattr(wrong, "axis", None) == 1 else None
    assert fault["joint"] == joint
    assert ("joint 2" in fault["sentence"]) == (joint == 2)


PAIRS = [(call, state) for call, states in STAGES.items() for state in states]


MOST_UNLIKE = ("a fault of one axis", "a fault of the bus", "the end of the process")
ONCE = [(call, thrown) for call in STAGES for thrown in (THROWN if call == "read" else MOST_UNLIKE)]


@pytest.mark.by_default(
    "enable-a fault of one axis",
    "read-a fault of the bus",
    "read-an error of the code",
    "read-no memory",
    "write-the end of the process",
    "switching-a fault of one axis",
    "disable-a fault of the bus",
    "reset-a fault of one axis",
)
@pytest.mark.parametrize(("call", "thrown"), ONCE)
def test_a_call_that_breaks_once_ends_in_fault_and_says_why(call, thrown):
    for state in STAGES[call]:
        arm, backend = brought_to(state)
        backend.once[call] = THROWN[thrown]
        enter(arm, state)
        for _ in range(200):
            if arm.fault is not None and not backend.once:
                break
            arm.cycle()
        assert not backend.once, (call, state)
        wait_for_its_end(arm)
        assert_told(arm, thrown)
        assert_no_torque(arm, backend)
        arm.reset()
        until(arm, INACTIVE, seconds=1.0)
        arm.enable()
        until(arm, ArmState.HOLDING, seconds=2.0)
        assert arm.fault is None


@pytest.mark.by_default(
    "enable",
    "read-enabling",
    "read-running",
    "read-stopping",
    "write-holding",
    "write-running",
    "switching-enabling",
    "reset",
    "disable",
)
@pytest.mark.parametrize(("call", "state"), PAIRS)
def test_a_call_that_stays_broken_ends_without_torque(call, state):
    for thrown in ("an error of the code", "a fault of the bus"):
        arm, backend = brought_to(state)
        backend.broken[call] = THROWN[thrown]
        enter(arm, state)
        for _ in range(int(AT_LAST / PERIOD)):
            arm.cycle()
            if arm.state == FAULT:
                break
        assert arm.state == FAULT, (thrown, arm.state.label)
        assert_told(arm, thrown)
        assert_no_torque(arm, backend)
        backend.broken.clear()
        cycles(arm, 20)
        assert not backend.powered, "a backend that works again is told to switch off"


def assert_no_torque(arm: Arm, backend: FaultyBackend) -> None:
    """None is asked for any more, and whoever may still be powered is told to switch off."""
    assert arm.state not in POWERED
    assert not arm.path.sent.any()
    backend.written.clear()
    cycles(arm, 5)
    assert not np.any(backend.written)
    assert not backend.powered or arm.maybe_powered


@pytest.mark.parametrize("thrown", THROWN)
def test_a_robot_that_cannot_be_opened_says_why(thrown):
    backend = FaultyBackend()
    backend.broken["open"] = backend.broken["close"] = THROWN[thrown]
    answer = Commands(arm_on(backend), None, servo).carry_out({"id": 1, "do": "connect"})
    wrong = THROWN[thrown]()
    words = str(wrong.args[0]) if wrong.args else type(wrong).__name__
    assert not answer["ok"]
    assert answer["state"] == "offline"
    assert words[:5] in answer["detail"]
    if thrown == "an error of the code":
        assert "the backend broke in 'open': TypeError" in answer["detail"]
        assert "joint servo" not in answer["detail"]
    backend.broken.clear()
    arm = arm_on(backend)
    arm.connect()
    assert arm.state == INACTIVE


@pytest.mark.parametrize("thrown", THROWN)
def test_a_bus_that_cannot_be_left_says_why(thrown):
    arm, backend = brought_to("inactive")
    backend.once["close"] = THROWN[thrown]
    answer = Commands(arm, None, servo).carry_out({"id": 1, "do": "disconnect"})
    wrong = THROWN[thrown]()
    assert answer["ok"]
    assert answer["state"] == "offline"
    assert (str(wrong.args[0]) if wrong.args else type(wrong).__name__)[:5] in answer["said"]
    assert arm.fault is None


@pytest.mark.long
def test_a_stop_of_the_drives_that_breaks_hides_no_reason():
    for thrown in THROWN:
        arm, backend = brought_to("running")
        backend.broken["quick_stop"] = THROWN[thrown]
        backend.once["read"] = THROWN["a fault of the bus"]
        wait_for_its_end(arm)
        assert_told(arm, "a fault of the bus")
        assert_no_torque(arm, backend)


def test_warnings_that_break_are_a_warning():
    arm, backend = brought_to("holding")
    backend.broken["warnings"] = THROWN["an error of the code"]
    (said,) = describe(arm).warnings
    assert "the backend broke in 'warnings': TypeError" in said
    assert arm.state == ArmState.HOLDING


def reading(change):
    def read(feedback):
        change(feedback)
        return feedback

    return read


def spoil(name, axis, value):
    def change(feedback):
        values = getattr(feedback, name).copy()
        values[axis] = value
        setattr(feedback, name, values)

    return reading(change)


READS = {
    "no position": (spoil("q", 1, np.nan), "no_number", 2, "its position was read as nan"),
    "a torque that is none": (spoil("tau", 0, np.inf), "no_number", 1, "torque was read as inf"),
    "nothing": (lambda _: "nothing", "backend", None, "the backend broke in 'read'"),
    "too few joints": (
        reading(lambda f: setattr(f, "q", f.q[:1])), "backend", None, "the backend broke in 'read'"
    ),
    "words for numbers": (
        reading(lambda f: setattr(f, "q", np.array(["a", "b"]))), "backend", None, "of <U1"
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", READS)
@pytest.mark.parametrize("state", ["inactive", "holding", "running"])
def test_a_reading_that_is_none_is_not_taken_in(case, state):
    reads, kind, joint, says = READS[case]
    arm, backend = brought_to(state)
    backend.reads = reads
    cycles(arm, 1)
    backend.reads = None
    wait_for_its_end(arm)
    fault = describe(arm).fault
    assert (fault.kind, fault.joint) == (kind, joint)
    assert says in fault.sentence
    rows, _ = arm.journal.ring.read(0)
    assert np.isfinite(arm.journal.ring.layout.get(rows, "q")).all()
    arm.reset()
    until(arm, INACTIVE, seconds=1.0)
    assert np.isfinite(arm.path.dq).all()


def test_the_loop_outlives_what_its_backend_throws():
    """As the control process runs it, to the end, and it answers all the while."""
    backend = FaultyBackend()
    arm = arm_on(backend)
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    loop = Loop(arm, arm.journal.ring, Commands(arm, None, servo), ours)
    daemon = Mailbox(theirs)
    arm.connect()
    arm.enable()
    until(arm, ArmState.HOLDING)
    backend.broken = dict.fromkeys(["read", "write", "warnings", "close"], THROWN["no memory"])
    daemon.tell({"do": "alive"})
    daemon.tell({"id": 1, "do": "stop"})
    daemon.tell({"id": 2, "do": "end"})
    loop.run()
    told = []
    while (message := daemon.take()) is not None:
        told.append(message)
    faults = [one["fault"] for one in told if one.get("fault")]
    assert faults
    assert "the backend broke in 'read': MemoryError" in faults[0]["sentence"]
    assert {one["reply"] for one in told if "reply" in one} == {1}
    assert {"event": "alive"} in told, "so that the daemon knows that it does not hang"
    assert arm.state == OFFLINE
    ours.close()
    theirs.close()


class Remembering(FaultyBackend):
    """One whose drives keep a history."""

    def read_errors(self):
        self.throw("read_errors")
        return [DriveErrors(1, 0x2310, (0x2310,)), DriveErrors(problem="no answer")]

    def clear_errors(self):
        return [DriveErrors(1, 0x2310, ()), DriveErrors(problem="no answer")]


def test_what_drives_remember_is_told_while_the_arm_is_unpowered():
    backend = Remembering()
    arm = arm_on(backend)
    commands = Commands(arm, None, servo)
    for bring in ((), (arm.connect,)):
        for do in bring:
            do()
        first, second = commands.carry_out({"id": 1, "do": "errors"})["drives"]
        assert first["history"][0]["words"] == "0x2310 (overcurrent)"
        assert second["problem"] == "no answer"
        (first, _) = commands.carry_out({"id": 1, "do": "errors", "clear": True})["drives"]
        assert first["history"] == []
    backend.once["read_errors"] = THROWN["an error of the code"]
    refused = commands.carry_out({"id": 1, "do": "errors"})
    assert "the backend broke in 'errors': TypeError" in refused["detail"]
    assert arm.fault is None
    arm.enable()
    until(arm, ArmState.HOLDING)
    refused = commands.carry_out({"id": 1, "do": "errors"})
    assert refused["needed"] == ["offline", "inactive", "fault"]
    none = Commands(arm_on(FaultyBackend()), None, servo).carry_out({"id": 1, "do": "errors"})
    assert "keep no history of errors" in none["detail"]
