"""A backend without a control loop: for scripts, benches and tests. Nobody watches the arm here."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from backends.protocol import Array, Backend, Feedback

Torque = Callable[[Feedback], Array]


def enable(arm: Backend, hold: Torque | None = None) -> None:
    """Until all axes are powered; ``hold`` gives the torques that meet the load, default zero."""
    arm.begin_enable()
    carry_out(arm, hold)


def disable(arm: Backend, hold: Torque | None = None) -> None:
    """Until the brakes are on and the power is off."""
    arm.begin_disable()
    carry_out(arm, hold)


def reset(arm: Backend) -> None:
    """Until every fault is acknowledged."""
    arm.begin_reset()
    carry_out(arm)


def carry_out(arm: Backend, torque: Torque | None = None) -> None:
    """Cycles, paced where time is real, until what was begun is done."""
    pace, nothing = pacer(arm), np.zeros(arm.n)
    while arm.switching:
        pace()
        feedback = arm.read()
        arm.write(nothing if torque is None else torque(feedback))


def pacer(arm: Backend) -> Callable[[], None]:
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
