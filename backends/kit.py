"""What every backend must keep, tried on one: the conformance kit for ``backends/protocol.py``.

The arm is enabled, held with the torques that are given, stopped, disabled, reset and opened once
more: where it is a real one, it needs room, and brakes that hold.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from backends.by_hand import Torque, pacer
from backends.faults import REMEDIES
from backends.protocol import Backend, BackendFault, Feedback, RelievesMotors

PATIENCE = 60.0  # s on the backend's own clock for what was begun to be done
HELD = 50  # cycles
LIVES = 2  # a device is opened more than once
RELIEVED = ("begin_enable", "begin_relieve")  # and enabled from there, where that is offered
STEPS = ("begin_enable", "quick_stop", "begin_disable", "begin_reset")


def broken_promises(make: Callable[[], Backend], hold: Torque | None = None) -> list[str]:
    """A sentence for each promise that is not kept; none: it may hold an arm.

    make: a backend that is not yet open; hold: torques that meet the load, default zero."""
    return list(dict.fromkeys(_tried(make(), hold)))


def _tried(arm: Backend, hold: Torque | None) -> Iterator[str]:
    yield from _shape(arm)
    nothing = np.zeros(arm.n)
    for _ in range(LIVES):
        try:
            yield from _life(arm, hold or (lambda _: nothing))
        except BackendFault as fault:
            yield from _named(fault)
            yield f"a fault in an ordinary life: {fault}"
        except Exception as error:
            yield f"{type(error).__name__} where only BackendFault may come: {error}"
        finally:
            arm.close()


def _shape(arm: Backend) -> Iterator[str]:
    if not (isinstance(arm.n, int) and arm.n > 0):
        yield f"n is {arm.n!r}; expected the number of joints"
    if not arm.period > 0:
        yield f"period is {arm.period!r}; expected seconds"
    if not isinstance(arm.realtime, bool):
        yield f"realtime is {arm.realtime!r}; expected True or False"


def _life(arm: Backend, hold: Torque) -> Iterator[str]:
    arm.open()
    if arm.switching:
        yield "switching right after open; nothing was begun"
    if not all(isinstance(line, str) for line in arm.warnings):
        yield f"warnings are {arm.warnings!r}; expected a list of sentences"
    cycles = _Cycles(arm, hold)
    relieved = RELIEVED if isinstance(arm, RelievesMotors) else ()
    for step in (*relieved, *STEPS):
        with cycles.counted(step):
            getattr(arm, step)()
        if step == "begin_reset":
            cycles.begin_anew()
        yield from cycles.until_done(step)
        yield from cycles.some(step)


class _Cycles:
    def __init__(self, arm: Backend, hold: Torque) -> None:
        self._arm, self._hold, self._pace = arm, hold, pacer(arm)
        self._last, self._hidden = -np.inf, ""

    def begin_anew(self) -> None:
        """A device may set its clock to zero as it is reset."""
        self._last = -np.inf

    @contextmanager
    def counted(self, step: str) -> Iterator[None]:
        """A step that reads by itself carries a loop of its own."""
        reads, read = 0, self._arm.read

        def counting() -> Feedback:
            nonlocal reads
            reads += 1
            return read()

        self._arm.read = counting  # type: ignore[method-assign]
        try:
            yield
        finally:
            del self._arm.read
        self._hidden = f"{step} reads {reads} times by itself: no loop may hide in it" * bool(reads)

    def until_done(self, step: str) -> Iterator[str]:
        """Cycles until the step is carried out."""
        if self._hidden:
            yield self._hidden
        for _ in range(round(PATIENCE / self._arm.period)):
            if not self._arm.switching:
                return
            yield from self._one(step)
        yield f"{step}: still switching after {PATIENCE:g} s; expected an end, or a fault 'timeout'"

    def some(self, step: str) -> Iterator[str]:
        """Ordinary cycles behind it."""
        for _ in range(HELD):
            yield from self._one(step)

    def _one(self, step: str) -> Iterator[str]:
        self._pace()
        seen = self._arm.read()
        yield from (f"after {step}: {said}" for said in self._wrong(seen))
        self._last = seen.time
        self._arm.write(self._hold(seen))

    def _wrong(self, seen: Feedback) -> Iterator[str]:
        n = self._arm.n
        blocks = {"q": seen.q, "tau": seen.tau, "status": seen.status, "age": seen.age}
        if seen.temperature is not None:
            blocks["temperature"] = seen.temperature
        for name, block in blocks.items():
            if np.shape(block) != (n,):
                yield f"{name} has the shape {np.shape(block)}; expected ({n},)"
        for name in ("q", "tau"):
            if not np.isfinite(blocks[name]).all():
                yield f"{name} is not finite"
        for name in ("status", "age"):
            if not np.issubdtype(np.asarray(blocks[name]).dtype, np.integer):
                yield f"{name} is {np.asarray(blocks[name]).dtype}; expected integers"
        if np.min(seen.age) < 0:
            yield "age is negative; expected cycles since the value was fresh"
        if not seen.time > self._last:
            yield "time does not go on from read to read"


def _named(fault: BackendFault) -> Iterator[str]:
    if fault.kind not in REMEDIES:
        yield f"fault of kind {fault.kind!r}: not in backends/faults.py"
    if not fault.remedy:
        yield f"fault of kind {fault.kind!r} without a remedy"
