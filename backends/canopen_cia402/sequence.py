"""Power on, power off and acknowledge: all axes side by side, one step per cycle."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from backends.cia402 import TOWARDS_DISABLED, TOWARDS_ENABLED, Control, State, state_of
from backends.faults import fault
from backends.protocol import Array, Feedback, Hold

if TYPE_CHECKING:
    from backends.canopen_cia402.backend import CanopenBackend

STILL, STILL_CYCLES = 2e-4, 10  # rad a cycle, and for how many cycles
OFF = (State.DISABLED, State.FAULT)
PATIENCE = 5.0  # s, on the backend's clock, for any of these sequences

# faults after which the drive still has our configuration; after all others it is set up anew
STILL_CONFIGURED = ("drive_fault", "left_enabled", "encoder_jump", "repeated_pdo", "timeout")


def enable(arm: CanopenBackend, hold: Hold | None) -> None:
    """Every axis to SWITCHED ON, then all brakes in the same cycle."""
    torques = hold or (lambda feedback: np.zeros(arm.n))

    def step(feedback: Feedback, states: list[State | None], last: bool) -> None:
        words = [TOWARDS_ENABLED.get(s) if s else None for s in states]
        if not last:
            words = [Control.SWITCH_ON if w is Control.ENABLE else w for w in words]
        arm.set_words([w if w is not None else Control.DISABLE_VOLTAGE for w in words])
        arm.write(torques(feedback))

    for goal, last in ((State.SWITCHED_ON, False), (State.ENABLED, True)):
        reached = (goal, State.ENABLED)
        _run(
            arm,
            lambda feedback, states, last=last: step(feedback, states, last),  # type: ignore[misc]
            lambda states, reached=reached: [s in reached for s in states],  # type: ignore[misc]
            f"does not reach '{goal}'",
        )


def disable(arm: CanopenBackend) -> None:
    """Brakes on while the drives still hold, then power off; silent axes are left aside.

    An axis in its quick stop is left to finish it: power off would drop it into its brake.
    """
    standing = Standing(arm.n)

    def step(feedback: Feedback, states: list[State | None]) -> None:
        stands = standing.after(feedback.q)
        words = [TOWARDS_DISABLED.get(s) if s else None for s in states]
        for axis, state in enumerate(states):
            if state is State.QUICK_STOP and not stands[axis]:
                words[axis] = Control.QUICK_STOP
        arm.command([Control.DISABLE_VOLTAGE if w is None else w for w in words])

    _run(
        arm,
        step,
        lambda states: [s in OFF or arm.silent(k) for k, s in enumerate(states)],
        "does not switch off",
        judge=False,
    )


class Standing:
    """Which axes have not moved for a while."""

    def __init__(self, n: int) -> None:
        self._last = np.full(n, np.inf)
        self._still = np.zeros(n, int)

    def after(self, q: Array) -> NDArray[np.bool_]:
        """Whether each axis stands, now that it was seen at ``q`` (n,), rad."""
        self._still = np.where(np.abs(q - self._last) < STILL, self._still + 1, 0)
        self._last = q.copy()
        return self._still >= STILL_CYCLES


def acknowledge(arm: CanopenBackend) -> None:
    """Fault reset on every axis that asks for it, and all axes unpowered."""
    raised = [False] * arm.n

    def step(feedback: Feedback, states: list[State | None]) -> None:
        words = []
        for axis, state in enumerate(states):
            # the reset is a rising edge: now high, now low, until the drive takes it
            raised[axis] = state is State.FAULT and not raised[axis]
            towards = TOWARDS_DISABLED.get(state) if state else None
            words.append(Control.FAULT_RESET if raised[axis] else towards or Control(0))
        arm.command(words)

    _run(
        arm,
        step,
        lambda states: [s is State.DISABLED for s in states],
        "does not leave its fault: the cause persists",
        judge=False,
    )


def prove(arm: CanopenBackend, cycles: int) -> None:
    """A few cycles without power: do PDOs flow from everybody?"""
    pace = _pacer(arm)
    for _ in range(cycles + arm.profile.safety.stale_cycles):
        pace()
        feedback = arm.cycle()
        arm.command([Control.DISABLE_VOLTAGE] * arm.n)
        if feedback.age.max() == 0 and (cycles := cycles - 1) <= 0:
            return
    for axis in np.flatnonzero(feedback.age):
        raise fault("no_answer", "sends no TPDO on SYNC although configured to", int(axis))


def _run(
    arm: CanopenBackend,
    step: Callable[[Feedback, list[State | None]], None],
    done: Callable[[list[State | None]], list[bool]],
    complaint: str,
    judge: bool = True,
) -> None:
    """Cycles until every axis is done; ``judge``: any fault ends the sequence."""
    pace = _pacer(arm)
    started: float | None = None
    while True:
        pace()
        feedback = arm.read() if judge else arm.cycle()
        states = [state_of(int(word)) for word in feedback.status]
        reached = done(states)
        if all(reached):
            return
        started = feedback.time if started is None else started
        if feedback.time - started > PATIENCE:
            axis = reached.index(False)
            shown = states[axis] or f"statusword 0x{int(feedback.status[axis]):04X}"
            raise fault("timeout", f"{complaint} in {PATIENCE:g} s, it is '{shown}'", axis)
        step(feedback, states)


def _pacer(arm: CanopenBackend) -> Callable[[], None]:
    """Waits for the next cycle where time is real."""
    due = time.monotonic()

    def pace() -> None:
        nonlocal due
        if not arm.realtime:
            return
        left = due - time.monotonic()
        if left > 0:
            time.sleep(left)
        due = max(due + arm.period, time.monotonic() - arm.period)

    return pace
