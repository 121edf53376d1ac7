"""No sequence of commands and faults gives torque where none may be, or leaves a fault alone.

Nor is there torque in a cycle in which nobody looked whether the arm is where it may be, and none
acts on a joint that has been outside for longer than docs/faults.md says. An arm beyond its
position limits is powered on request only, and goes no further out.
"""

from __future__ import annotations

import logging
from collections import Counter

import hypothesis
import numpy as np
import pytest
from arms import flywheel_arm, limits, servo, swing, way_in
from fake_backend import RelievingBackend
from how_often import how_often
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    rule,
    run_state_machine_as_test,
)

from backends.protocol import BackendFault
from pa10d.control.envelope import OVERSHOOT
from pa10d.control.outside import FARTHEST, outside
from pa10d.control.states import POWERED, SWITCHING, ArmState, Refused
from pa10d.control.torque_path import RUNAWAY

FAULTS = st.builds(lambda axis: BackendFault("injected", axis=axis), st.sampled_from([None, 0, 1]))
CALLS = st.sampled_from(
    ["read", "read", "write", "enable", "disable", "relieve", "reset", "quick_stop"]
)
AXES = st.integers(0, 1)
RARELY = st.sampled_from([False, False, False, True])
NEXT = {  # what may follow in one step that is not a reset
    ArmState.OFFLINE: {ArmState.OFFLINE, ArmState.INACTIVE, ArmState.FAULT},
    ArmState.FAULT: {ArmState.FAULT, ArmState.OFFLINE},
}
OUTSIDE = 12  # cycles for which torque may act on a joint outside its envelope
REST = 4000  # cycles in which every arm comes to rest once nothing fails any more


def short_swing(start, amplitude):
    """As fast as the acceleration limit allows, or faster: amplitudes of 4 rad are refused."""
    fastest = np.pi * np.sqrt(2.0 * amplitude / limits().acceleration[0])
    return swing(start, amplitude, min(max(1.1 * fastest, 0.5), 3.0))


class ModelServo:
    """A joint servo, and a model that says this torque for every joint, N·m."""

    name = "model"

    def __init__(self, torque):
        self.said, self.servo = torque, servo()

    def model_torque(self, q, dq, ddq):
        return np.full(np.shape(q), self.said)

    def start(self, reference, q, dq, torque):
        self.servo.start(reference, q, dq, torque - self.said)

    def torque(self, reference, q, dq):
        return self.said + self.servo.torque(reference, q, dq)

    def applied(self, wanted, sent):
        self.servo.applied(wanted - self.said, sent - self.said)


class Commander(RuleBasedStateMachine):
    """Commands of a careless client, faults of drives and controllers, and time."""

    seen: Counter[str] = Counter()

    @initialize()
    def connect(self):
        self.arm, self.backend = flywheel_arm(capacity=64, drives=RelievingBackend)
        self.astray: list[object] = []  # torque that came where none may be
        write, step = self.backend.write, self.backend.plant.step
        self.looked, self.outside, self.longest = False, np.zeros(2, dtype=int), 0
        self.nearest = np.zeros(2)  # rad beyond its limits, that each joint was at least
        self.step = step
        path = self.arm.path
        for name in ("watch", "watch_standing"):
            setattr(path, name, self.noting(getattr(path, name)))

        def watched_write(torque):
            if np.any(torque != 0) and self.arm.state not in POWERED:
                self.astray.append(("sent", self.arm.state, torque))
            if np.any(torque != 0) and not self.looked:
                self.astray.append(("unwatched", self.arm.state, torque))
            write(torque)

        def watched_step(torque, dt):
            told = not self.arm.maybe_powered  # else: the drives do not listen, and are told again
            if np.any(torque != 0) and self.arm.state not in POWERED and told:
                self.astray.append(("acts", self.arm.state, torque))
            step(torque, dt)
            self.outside = np.where(self.is_outside() & (torque != 0), self.outside + 1, 0)
            self.longest = max(self.longest, int(self.outside.max()))
            if self.outside.max() > OUTSIDE:
                self.astray.append(("outside", self.arm.state, torque))
            self.nearest = np.minimum(self.nearest, self.beyond())

        self.backend.write, self.backend.plant.step = watched_write, watched_step
        self.arm.connect()
        self.cycle(3)

    def noting(self, watch):
        def watched(*arguments, **more):
            self.looked = True
            return watch(*arguments, **more)

        return watched

    def is_outside(self):
        """By what the plant knows, not by what the loop estimates."""
        path, limits, plant = self.arm.path, self.arm.path.limits, self.backend.plant
        far = np.abs(plant.q - path.reference.q) > RUNAWAY * limits.following_error
        far |= np.abs(plant.dq) > RUNAWAY * limits.velocity
        if self.arm.state in (ArmState.HOLDING, ArmState.RUNNING):
            further = self.beyond() - self.nearest > RUNAWAY * OVERSHOOT
            far |= further & (plant.dq * np.sign(plant.q) >= 0.0)
        return far

    def beyond(self):
        """(n,) rad that each joint is beyond its position limits, 0 inside."""
        return np.maximum(np.abs(self.backend.plant.q) - self.arm.path.limits.upper, 0.0)

    def ask(self, command, *arguments, **more):
        before, refused = self.arm.state, None
        doubted = bool(self.arm.whereabouts.misplaced)
        try:
            command(*arguments, **more)
        except Refused as refusal:
            refused = refusal
        assert refused is None or (refused.remedy and self.arm.state == before)
        self.seen[f"{'refused' if refused else 'done'} {command.__name__}"] += 1
        if command == self.arm.enable and before == ArmState.INACTIVE:
            assert refused or not doubted
            self.seen["not believed"] += doubted
        self.watch(before, reset=command == self.arm.reset)

    def watch(self, before, reset=False):
        after = self.arm.state
        if before in NEXT and not reset:
            assert after in NEXT[before], (before, after)
        if after == ArmState.FAULT != before:
            self.seen[f"fault {self.arm.fault.kind}"] += 1

    # -- time -------------------------------------------------------------------------------

    @rule(count=st.integers(1, 60))
    def cycle(self, count):
        for _ in range(count):
            before, self.looked = self.arm.state, False
            self.arm.cycle()
            self.seen[f"cycle {before.label}"] += 1
            self.watch(before)

    @rule()
    def wait(self):
        """Until the motion or the stop under way is over."""
        for _ in range(REST):
            if self.arm.state not in {ArmState.RUNNING, ArmState.STOPPING} | SWITCHING:
                return
            self.cycle(1)
        raise AssertionError(f"{self.arm.state} for ever")

    def settle(self):
        """Until the drives have switched, as far as they do."""
        for _ in range(REST):
            if self.arm.state not in SWITCHING:
                return
            self.cycle(1)
        raise AssertionError(f"{self.arm.state} for ever")

    # -- commands ---------------------------------------------------------------------------

    @rule()
    def power_up(self):
        """Whatever it takes, as far as the faults that wait allow it."""
        self.leave_fault()
        self.ask(self.arm.enable)
        self.settle()

    def leave_fault(self):
        if self.arm.state == ArmState.FAULT:
            self.ask(self.arm.reset)
        if self.arm.state == ArmState.OFFLINE:
            self.ask(self.arm.connect)
        self.cycle(2)
        self.settle()
        self.look()

    def look(self):
        """Somebody compares the arm with what is read, and believes it."""
        if self.arm.whereabouts.misplaced:
            self.ask(self.arm.confirm)

    @rule(amplitude=st.sampled_from([0.1, 0.3, 1.0, 1.5, 4.0]), cycles=st.integers(0, 60))
    def go(self, amplitude, cycles):
        """From wherever the arm stands into a motion."""
        self.power_up()
        self.run_motion(amplitude, 0.0)
        self.cycle(cycles)

    @rule()
    def enable(self):
        self.ask(self.arm.enable)

    @rule(
        axis=AXES, by=st.sampled_from([0.01, 0.05, 0.15, 0.5]), side=st.sampled_from([-1, 1]),
        recover=st.sampled_from([True, True, False]), inward=st.sampled_from([True, True, False]),
        cycles=st.integers(0, 1500),
    )  # fmt: skip
    def come_back(self, axis, by, side, recover, inward, cycles):
        """Somebody turns a joint of an unpowered arm beyond its limit; it is powered only where
        that is asked for and it is not too far, and goes nowhere but inside."""
        self.ask(self.arm.disable)
        self.wait()
        self.leave_fault()
        if self.arm.state != ArmState.INACTIVE:
            return
        high = limits().upper
        self.backend.plant.q[axis] = side * (high[axis] + by)
        self.cycle(2)
        if self.arm.whereabouts.misplaced:
            self.ask(self.arm.enable, recover=recover)
        self.look()
        seen, before = outside(self.arm.path.q, -high, high), self.arm.state
        self.ask(self.arm.enable, recover=recover)
        if before == ArmState.INACTIVE and self.arm.state == ArmState.ENABLING:
            self.nearest = self.beyond()
            self.seen["powered outside"] += bool(seen)
            assert not seen or (recover and max(one.beyond for one in seen) <= FARTHEST)
        self.settle()
        at = self.arm.path.reference.q.copy()
        there = np.clip(at, 0.03 - high, high - 0.03) if inward else at + 0.03 * np.sign(at)
        self.ask(self.arm.run, way_in(at, there))
        if self.arm.state == ArmState.RUNNING and (np.abs(at) > high).any():
            assert inward
            self.seen["way in"] += 1
        self.cycle(cycles)

    @rule(anyway=RARELY)
    def disable(self, anyway):
        self.ask(self.arm.disable, anyway=anyway)

    @rule(axis=AXES, weak=st.booleans())
    def leave_it_to_its_brakes(self, axis, weak):
        """An arm that is held: power goes where its brakes hold it, and nowhere else."""
        self.power_up()
        self.backend.weak[axis] = weak
        held = self.arm.state == ArmState.HOLDING
        self.ask(self.arm.disable)
        self.settle()
        if held and self.arm.state == ArmState.HOLDING:
            assert self.arm.unheld
            assert all(self.backend.weak[one.axis] for one in self.arm.unheld)
            self.seen["not left to a weak brake"] += 1
        if held and self.arm.state == ArmState.INACTIVE:
            assert not (self.backend.weak & ~self.backend.frozen).any()
            self.seen["left to its brakes"] += 1

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
        self.ask(self.arm.run, short_swing(self.arm.path.reference.q + away, amplitude))

    @rule()
    def change_controller(self):
        self.ask(self.arm.use, servo())

    @rule(torque=st.sampled_from([0.0, 3.0, 20.0, 1e3, np.nan]))
    def change_model(self, torque):
        """Only one that holds the arm with about the torque that does now."""
        before = self.arm.path.controller
        self.ask(self.arm.use, ModelServo(torque))
        self.seen[f"model {torque:g}"] += 1
        if not torque < 10.0:
            assert self.arm.path.controller is before or abs(torque) <= 25.0

    # -- faults -----------------------------------------------------------------------------

    @rule()
    def lose_the_daemon(self):
        before = self.arm.state
        self.arm.emergency("daemon_gone", "gone")
        self.watch(before)

    @rule(call=CALLS, fault=FAULTS)
    def fail_next(self, call, fault):
        self.backend.fail.setdefault(call, []).append(fault)

    @rule(unplugged=st.booleans())
    def plug(self, unplugged):
        self.backend.unplugged = unplugged

    @rule(axis=AXES, frozen=st.booleans())
    def freeze(self, axis, frozen):
        self.backend.frozen[axis] = frozen

    @rule(axis=AXES, cycles=st.integers(1, 60))
    def fall_silent(self, axis, cycles):
        """A drive of a powered arm is not heard for a while."""
        self.power_up()
        self.backend.frozen[axis] = True
        self.cycle(cycles)
        self.backend.frozen[axis] = False

    @rule(axis=AXES, stuck=RARELY)
    def hold_up_a_drive(self, axis, stuck):
        """It never says that it is enabled."""
        self.backend.stuck[axis] = stuck

    @rule(axis=AXES, inverted=RARELY)
    def invert_a_sign(self, axis, inverted):
        self.backend.inverted[axis] = inverted
        self.seen["sign"] += inverted

    @rule(periods=st.integers(1, 40))
    def come_late(self, periods):
        """The drives hold the last torque meanwhile."""
        if self.backend.opened and self.backend.powered and not self.backend.braked:
            if not self.backend.quick:
                self.step(self.backend.torque, periods * self.backend.period)
            self.seen["late"] += 1
        self.backend.time += periods * self.backend.period

    @rule(axis=AXES, push=st.floats(-0.3, 0.3))
    def push(self, axis, push):
        self.backend.plant.q[axis] += push

    @rule(kick=st.sampled_from([-5.0, 5.0]), axis=AXES)
    def kick(self, axis, kick):
        self.backend.plant.dq[axis] += kick

    @rule(broken=st.sampled_from([RuntimeError("broken"), np.nan, np.inf, 1e9]))
    def break_controller(self, broken):
        def torque(*_):
            if isinstance(broken, Exception):
                raise broken
            return np.full(2, broken)

        self.arm.path.controller.torque = torque

    # -- what holds always ------------------------------------------------------------------

    @invariant()
    def torque_only_where_allowed(self):
        self.seen["step"] += 1
        assert not getattr(self, "astray", [])

    @invariant()
    def unpowered_where_no_torque_may_be(self):
        if hasattr(self, "arm") and self.arm.state in (ArmState.FAULT, ArmState.INACTIVE):
            off = not self.backend.powered or self.arm.maybe_powered
            assert off, "drives left powered and nobody cares"
            assert np.all(self.arm.path.sent == 0)

    @invariant()
    def torque_within_limits(self):
        if hasattr(self, "arm"):
            assert np.all(np.abs(self.arm.path.sent) <= self.arm.path.limits.torque)

    @invariant()
    def fault_state_has_a_fault(self):
        if hasattr(self, "arm"):
            assert (self.arm.state == ArmState.FAULT) <= (self.arm.fault is not None)
            assert self.arm.state != ArmState.INACTIVE or self.arm.fault is None

    def teardown(self):
        """Once nothing fails any more, a latched fault means brakes on and power off."""
        if not hasattr(self, "arm"):
            return
        self.seen["longest outside"] = max(self.seen["longest outside"], self.longest)
        self.backend.fail.clear()
        self.backend.unplugged = False
        if self.arm.fault is not None:
            self.wait()
        if self.arm.state in (ArmState.FAULT, ArmState.INACTIVE):
            self.cycle(20)
            assert not self.backend.powered


MOST = 40  # times 20 sequences
FAULT_KINDS = (
    "device",
    "interface_down",
    "controller",
    "following_error",
    "not_held",
    "stale",
    "daemon_gone",
    "not_finite",
)


def explore(examples, steps=50, seed=None, **more):
    """→ how often what was done and seen, in this many sequences."""

    class Counted(Commander):
        seen: Counter[str] = Counter()

    if seed is not None:
        hypothesis.seed(seed)(Counted)
    run_state_machine_as_test(
        Counted,
        settings=settings(
            max_examples=examples,
            stateful_step_count=steps,
            deadline=None,
            suppress_health_check=list(HealthCheck),
            **more,
        ),
    )
    return Counted.seen


@pytest.fixture(autouse=True)
def _quiet():
    """Thousands of faults, each with its line."""
    log = logging.getLogger("pa10d.control")
    log.disabled = True
    yield
    log.disabled = False


def missing(seen, steps):
    """What was tried too seldom, or None: what was never tried has not been shown."""
    wanted = {"step": steps}
    for state in set(ArmState) - {ArmState.OFFLINE}:
        wanted[f"cycle {state.label}"] = steps // 40
    left = ("left to its brakes", "not left to a weak brake")
    for place in ("powered outside", "way in", "not believed", *left):
        wanted[place] = max(3, steps // 1000)
    for command in ("enable", "disable", "stop", "reset", "run", "connect", "disconnect", "use"):
        wanted[f"done {command}"] = max(3, steps // 500)
    for kind in FAULT_KINDS:
        wanted[f"fault {kind}"] = 1
    return next((what for what, least in wanted.items() if seen[what] < least), None)


def test_no_sequence_gives_torque_where_none_may_be():
    """As many sequences as it takes until everything was tried: what a seed draws depends on the
    constants of all modules that some test has imported before."""
    seen: Counter[str] = Counter()
    for number in range(MOST):
        longest = seen["longest outside"]
        seen += explore(20, seed=number, database=None)
        seen["longest outside"] = max(longest, seen["longest outside"] - longest)
        if missing(seen, 2_500) is None:
            return
    raise AssertionError((missing(seen, 2_500), seen))


@pytest.mark.long
def test_nor_do_many_others(request):
    count = how_often(request.config, 100, 10_000)
    seen = explore(count, steps=12)
    print(dict(seen))
    request.node.user_properties += [
        ("kind", "sequences"), ("sequences", count), ("steps", seen["step"]),
        ("longest_cycles_outside", seen["longest outside"]),
    ]  # fmt: skip
    assert missing(seen, 10 * count) is None, (missing(seen, 10 * count), seen)
