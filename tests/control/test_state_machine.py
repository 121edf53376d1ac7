"""No sequence of commands and faults gives torque where none may be, or leaves a fault alone."""

from __future__ import annotations

import numpy as np
import pytest
from arms import flywheel_arm, swing
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from backends.protocol import BackendFault
from pa10d.control.states import POWERED, ArmState, Refused

FAULTS = st.builds(lambda axis: BackendFault("injected", axis=axis), st.sampled_from([None, 0, 1]))
CALLS = st.sampled_from(["read", "write", "enable", "disable", "reset", "quick_stop"])
NEXT = {  # what may follow in one step that is not a reset
    ArmState.OFFLINE: {ArmState.OFFLINE, ArmState.INACTIVE},
    ArmState.FAULT: {ArmState.FAULT, ArmState.OFFLINE},
}


class Commander(RuleBasedStateMachine):
    @initialize()
    def connect(self):
        self.arm, self.backend = flywheel_arm(capacity=64)
        self.was_reset = False
        write, hold_states = self.backend.write, []
        self.bad = hold_states

        def checked(torque):
            if np.any(torque != 0) and self.arm.state not in POWERED:
                self.bad.append((self.arm.state, torque))
            write(torque)

        self.backend.write = checked
        self.arm.connect()
        self.cycle(3)

    def ask(self, command, *arguments):
        before, refused = self.arm.state, None
        try:
            command(*arguments)
        except Refused as refusal:
            refused = refusal
        assert refused is None or (refused.remedy and self.arm.state == before)
        self.watch(before, reset=command == self.arm.reset)

    def watch(self, before, reset=False):
        after = self.arm.state
        if before in NEXT and not reset:
            assert after in NEXT[before], (before, after)

    @rule(count=st.integers(1, 400))
    def cycle(self, count):
        for _ in range(count):
            before = self.arm.state
            self.arm.cycle()
            self.watch(before)

    @rule()
    def enable(self):
        self.ask(self.arm.enable)

    @rule()
    def disable(self):
        self.ask(self.arm.disable)

    @rule()
    def stop(self):
        self.ask(self.arm.stop)

    @rule()
    def reset(self):
        self.ask(self.arm.reset)

    @rule()
    def reconnect(self):
        self.ask(self.arm.disconnect)
        self.ask(self.arm.connect)

    @rule(amplitude=st.sampled_from([0.3, 1.5, 4.0]), away=st.sampled_from([0.0, 0.0, 0.5]))
    def run_motion(self, amplitude, away):
        self.ask(self.arm.run, swing(self.arm.path.reference.q + away, amplitude))

    @rule()
    def lose_the_daemon(self):
        before = self.arm.state
        self.arm.emergency("daemon_gone", "gone")
        self.watch(before)

    @rule(call=CALLS, fault=FAULTS)
    def fail_next(self, call, fault):
        self.backend.fail.setdefault(call, []).append(fault)

    @rule(axis=st.integers(0, 1), frozen=st.booleans())
    def freeze(self, axis, frozen):
        self.backend.frozen[axis] = frozen

    @rule(axis=st.integers(0, 1), push=st.floats(-0.3, 0.3))
    def push(self, axis, push):
        self.backend.plant.q[axis] += push

    @rule()
    def break_controller(self):
        def broken(*_):
            raise RuntimeError("broken")

        self.arm.path.controller.torque = broken

    @invariant()
    def torque_only_where_allowed(self):
        assert not getattr(self, "bad", [])

    @invariant()
    def unpowered_where_no_torque_may_be(self):
        if hasattr(self, "arm") and self.arm.state in (ArmState.FAULT, ArmState.INACTIVE):
            off = not self.backend.powered or self.arm._maybe_powered
            assert off, "drives left powered and nobody cares"
            assert np.all(self.arm.path.sent == 0)

    @invariant()
    def fault_state_has_a_fault(self):
        if hasattr(self, "arm"):
            assert (self.arm.state == ArmState.FAULT) <= (self.arm.fault is not None)
            assert self.arm.state != ArmState.INACTIVE or self.arm.fault is None

    def teardown(self):
        """Once nothing fails any more, a latched fault means brakes on and power off."""
        if not hasattr(self, "arm"):
            return
        self.backend.fail.clear()
        for _ in range(4000):
            self.arm.cycle()
            if self.arm.state in (ArmState.FAULT, ArmState.INACTIVE):
                break
        if self.arm.state in (ArmState.FAULT, ArmState.INACTIVE):
            self.arm.cycle()
            assert not self.backend.powered


COMMON = {"deadline": None, "suppress_health_check": list(HealthCheck)}
TestShort = Commander.TestCase
TestShort.settings = settings(max_examples=60, stateful_step_count=40, **COMMON)


class Long(Commander):
    pass


TestLong = pytest.mark.long(Long.TestCase)
TestLong.settings = settings(max_examples=250, stateful_step_count=60, **COMMON)
