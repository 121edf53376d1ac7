"""Power on, power off and acknowledge: all axes side by side, one step per cycle."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from backends.cia402 import TOWARDS_DISABLED, TOWARDS_ENABLED, Control, DriveState, state_of
from backends.faults import fault
from backends.protocol import Array, Feedback

CREEPS, RESTS = 0.02, 0.2  # rad/s, slower than which for so many s a joint rests that …
SWAYS = 2.0  # … came out of its brake, or after so many s all the same: some sway for long
GIVES = 0.02  # rad that a joint in its brake may be pushed by one that falls
STILL, STILL_CYCLES = 2e-4, 10  # rad a cycle, and for how many cycles
OFF = (DriveState.DISABLED, DriveState.FAULT)
HEEDS_WITHIN = 3.0  # s for a drive to brake, close its brake and leave *operation enabled*
PATIENCE = 5.0  # s, on the backend's clock, for any step of these sequences

# faults after which the drive still has our configuration; after all others it is set up anew
STILL_CONFIGURED = ("drive_fault", "left_enabled", "encoder_jump", "repeated_pdo", "timeout")

States = list[DriveState | None]


class Axes(Protocol):
    """What a sequence needs of the backend."""

    @property
    def n(self) -> int: ...

    def cycle(self) -> Feedback:
        """SYNC and the answers to it, without judging them."""
        ...

    def set_words(self, words: list[Control]) -> None:
        """Controlwords of all axes, sent with the next torques."""

    def command(self, words: list[Control]) -> None:
        """Controlwords of all axes, sent now with the torques as they are."""

    def silent(self, axis: int) -> bool:
        """Whether the axis has not been heard for too long to be commanded."""
        ...

    def stop_node(self, axis: int) -> None:
        """NMT: its drive takes no more commands, and ends its torque by its own reaction."""


class Sequence(ABC):
    """``step`` after each cycle's answers; the words it leaves go out with the next torques."""

    judged = True  # whether new faults are told while it is under way
    complaint: str

    def __init__(self, arm: Axes) -> None:
        self.arm = arm
        self._started: float | None = None

    @abstractmethod
    def reached(self, states: States) -> list[bool]:
        """Which axes are where they shall be."""

    @abstractmethod
    def words(self, feedback: Feedback, states: States) -> list[Control]:
        """One step on for every axis."""

    def step(self, feedback: Feedback) -> bool:
        """Whether it is still under way; BackendFault where an axis does not obey in time."""
        states = [state_of(int(word)) for word in feedback.status]
        reached = self.reached(states)
        if all(reached):
            return self.next_stage()
        if self._started is None:
            self._started = feedback.time
        if feedback.time - self._started > PATIENCE:
            axis = reached.index(False)
            shown = states[axis] or f"statusword 0x{int(feedback.status[axis]):04X}"
            raise fault("timeout", f"{self.complaint} in {PATIENCE:g} s, it is '{shown}'", axis)
        self.arm.set_words(self.words(feedback, states))
        return True

    def next_stage(self) -> bool:
        """Every axis is there; whether there is more to do."""
        return False


class Enable(Sequence):
    """Every axis to SWITCHED ON, then all brakes in the same cycle."""

    _goal = DriveState.SWITCHED_ON

    @property
    def complaint(self) -> str:  # type: ignore[override]
        return f"does not reach '{self._goal}'"

    def reached(self, states: States) -> list[bool]:
        return [s in (self._goal, DriveState.ENABLED) for s in states]

    def words(self, feedback: Feedback, states: States) -> list[Control]:
        words = [TOWARDS_ENABLED.get(s) if s else None for s in states]
        if self._goal is not DriveState.ENABLED:
            words = [Control.SWITCH_ON if w is Control.ENABLE else w for w in words]
        return [w if w is not None else Control.DISABLE_VOLTAGE for w in words]

    def next_stage(self) -> bool:
        if self._goal is DriveState.ENABLED:
            return False
        self._goal, self._started = DriveState.ENABLED, None
        self.arm.set_words([Control.ENABLE] * self.arm.n)
        return True


class EnableOneByOne(Enable):
    """Every axis to SWITCHED ON; then each brake opens alone, from the base outwards, until its
    joint rests, and closes again; then all of them together: of joints that fall at once nobody
    knows whose weight is wrong, and by then each has shown its own.

    braked: (n,) of the profile; joints that have no brake are held from the beginning on.
    """

    def __init__(self, arm: Axes, braked: Iterable[bool]) -> None:
        super().__init__(arm)
        brakes = list(braked)
        self._held = [k for k, brake in enumerate(brakes) if not brake]
        self._waiting = [[], *([k] for k, brake in enumerate(brakes) if brake)]
        self._on: list[int] = []  # that shall be enabled now
        self._at: Array | None = None  # rad, where each was seen out of its brake last
        self._last: tuple[float, Array] | None = None  # s and rad
        self._there_at = self._moved_at = 0.0
        self._stopped: list[int] = []  # by their drives' own ramps, as they fell
        self._standing = Standing(arm.n)
        self.out: tuple[int, ...] | None = None  # of their brakes; None: all come out of them

    @property
    def complaint(self) -> str:  # type: ignore[override]
        return f"does not reach '{DriveState.ENABLED if self._on else DriveState.SWITCHED_ON}'"

    def reached(self, states: States) -> list[bool]:
        goals = [DriveState.SWITCHED_ON] * len(states)
        for axis in self._on:
            goals[axis] = DriveState.ENABLED
        return [state is goal for state, goal in zip(states, goals, strict=True)]

    def words(self, feedback: Feedback, states: States) -> list[Control]:
        words = super().words(feedback, states)
        for axis in self._on:
            towards = TOWARDS_ENABLED.get(state) if (state := states[axis]) else None
            words[axis] = towards or Control.DISABLE_VOLTAGE
        stands = self._standing.after(feedback.q)
        for axis in self._stopped:
            stops = states[axis] is DriveState.QUICK_STOP and not stands[axis]
            if stops or states[axis] is DriveState.ENABLED:
                words[axis] = Control.QUICK_STOP
        return words

    def again(self) -> None:
        """The joint that is tried falls: its drive stops it at once, its brake closes, and opens
        once more."""
        if self._tries:
            falls = self._on[len(self._held) :]
            self._waiting.insert(0, falls)
            self._stopped, self._standing = falls, Standing(self.arm.n)
            self._close()

    def step(self, feedback: Feedback) -> bool:
        states = [state_of(int(word)) for word in feedback.status]
        self._see(feedback, states)
        if not all(self.reached(states)):
            self._there_at = feedback.time
        elif self.out is not None and not self._rests(feedback.time):
            return True
        return super().step(feedback)

    def next_stage(self) -> bool:
        if len(self._on) == self.arm.n:
            return False
        if self._tries:
            self._close()
            return True
        if self._waiting:
            self._on, self._stopped = [*self._held, *self._waiting.pop(0)], []
            self.out = tuple(self._on)
        else:
            self._on, self.out = list(range(self.arm.n)), None
        self._tell()
        return True

    @property
    def _tries(self) -> bool:
        """Whether a joint is out of its brake alone."""
        return len(self._held) < len(self._on) < self.arm.n

    def _close(self) -> None:
        self._on, self.out = list(self._held), tuple(self._held)
        self._tell()

    def _tell(self) -> None:
        self._started = None
        self._there_at = self._last[0] if self._last is not None else 0.0
        words = [Control.SWITCH_ON] * self.arm.n
        for axis in self._on:
            words[axis] = Control.ENABLE
        for axis in self._stopped:
            words[axis] = Control.QUICK_STOP
        self.arm.set_words(words)

    def _see(self, feedback: Feedback, states: States) -> None:
        """Where all are; BackendFault where one leaves its closed brake."""
        q = feedback.q.copy()
        if self._last is not None and feedback.time > self._last[0]:
            speed = np.abs(q - self._last[1]) / (feedback.time - self._last[0])
            if (speed[self._on] > CREEPS).any():
                self._moved_at = feedback.time
        self._last = feedback.time, q
        if self._at is None:
            self._at = q.copy()
        free = [state in (DriveState.ENABLED, DriveState.QUICK_STOP) for state in states]
        self._at = np.where(free, q, self._at)
        self._at[self._on] = q[self._on]
        if self.out is None:
            return
        for axis in np.flatnonzero(np.abs(q - self._at) > GIVES):
            opened = set(self._on) - set(self._held)
            others = "".join(f" as that of joint {k + 1} opened" for k in opened)
            raise fault("brake_gave", f"left its place in its brake{others}", int(axis))

    def _rests(self, now: float) -> bool:
        rested = now - max(self._there_at, self._moved_at)
        return rested >= RESTS or now - self._there_at >= SWAYS


class Disable(Sequence):
    """Brakes on while the drives still hold, then power off; silent axes are left aside.

    An axis in its quick stop is left to finish it: power off would drop it into its brake. One
    that stays enabled does not hear us, and would hold its last torque as long as we are alive:
    its node is stopped, as its drive takes the loss of its master (0x6007).
    """

    complaint = "does not switch off"

    def __init__(self, arm: Axes) -> None:
        super().__init__(arm)
        self._standing = Standing(arm.n)
        self._told_at: float | None = None  # s, when the axes were told for the first time
        self._stopped: set[int] = set()

    def reached(self, states: States) -> list[bool]:
        return [s in OFF or self.arm.silent(k) for k, s in enumerate(states)]

    def words(self, feedback: Feedback, states: States) -> list[Control]:
        stands = self._standing.after(feedback.q)
        words = [TOWARDS_DISABLED.get(s) if s else None for s in states]
        if self._told_at is None:
            self._told_at = feedback.time
        deaf = feedback.time - self._told_at > HEEDS_WITHIN
        for axis, state in enumerate(states):
            if deaf and state is DriveState.ENABLED and axis not in self._stopped:
                self._stopped.add(axis)
                self.arm.stop_node(axis)
            if state is DriveState.QUICK_STOP and not stands[axis]:
                words[axis] = Control.QUICK_STOP
        return [Control.DISABLE_VOLTAGE if w is None else w for w in words]


class Relieve(Disable):
    """As ``Disable``, but a drive that was enabled stays SWITCHED ON: its brake has the load, and
    its torque is one step away."""

    def reached(self, states: States) -> list[bool]:
        off = super().reached(states)
        return [r or s is DriveState.SWITCHED_ON for r, s in zip(off, states, strict=True)]

    def words(self, feedback: Feedback, states: States) -> list[Control]:
        words = super().words(feedback, states)
        ready = [s is DriveState.SWITCHED_ON for s in states]
        return [Control.SWITCH_ON if r else w for r, w in zip(ready, words, strict=True)]


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


class Acknowledge(Sequence):
    """Fault reset on every axis that asks for it, and all axes unpowered."""

    judged = False
    complaint = "does not leave its fault: the cause persists"

    def __init__(self, arm: Axes) -> None:
        super().__init__(arm)
        self._raised = [False] * arm.n

    def reached(self, states: States) -> list[bool]:
        return [s is DriveState.DISABLED for s in states]

    def words(self, feedback: Feedback, states: States) -> list[Control]:
        words = []
        for axis, state in enumerate(states):
            # the reset is a rising edge: now high, now low, until the drive takes it
            self._raised[axis] = state is DriveState.FAULT and not self._raised[axis]
            towards = TOWARDS_DISABLED.get(state) if state else None
            words.append(Control.FAULT_RESET if self._raised[axis] else towards or Control(0))
        return words


def prove(arm: Axes, cycles: int, patience: int, pace: Callable[[], None]) -> None:
    """A few cycles without power, ``patience`` more where need be: do PDOs flow from everybody?"""
    for _ in range(cycles + patience):
        pace()
        feedback = arm.cycle()
        arm.command([Control.DISABLE_VOLTAGE] * arm.n)
        if feedback.age.max() == 0 and (cycles := cycles - 1) <= 0:
            return
    for axis in np.flatnonzero(feedback.age):
        raise fault("no_answer", "sends no TPDO on SYNC although configured to", int(axis))
