"""The brake of a drive as one of its outputs (0x60FE:1, bit 0): set before power goes, released
under power only.

Most drives work their brakes by themselves and ignore the bit; whether it acts is the mask's affair
(0x60FE:2), which is left as it is: a brake that hangs on us alone would stay open when we die.
Where it hangs on us all the same, a quick stop keeps its power until the brake holds.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from math import inf

import numpy as np

from backends.canopen_cia402.remote import Remote
from backends.cia402 import Control
from backends.protocol import Array
from pa10d.profile import Drive

OUTPUTS, PHYSICAL, MASK, SET_BRAKE = 0x60FE, 1, 2, 1
ENABLED, IN_QUICK_STOP, REACTING = 0x27, 0x07, 0x0F  # bits of a statusword, see STATUS_BITS
CLOSES_IN = 0.15  # s from an output that is set to a brake that holds; until then the drive does
AGAIN = 0.05  # s after which a drive that did not confirm its output is told once more …
GIVEN_UP = 1.0  # … and from when on nobody waits for it

OWN_AFFAIR = (
    "no Digital outputs (0x60FE): the drive alone works its brake; see on the arm that it closes "
    "before power goes"
)
ON_US_ALONE = (
    "Digital outputs (0x60FE): its mask gives the brake to the control PC, and nobody sets it when "
    "that dies: have the drive set this output by itself on a fault"
)
NONE = "no brake by the profile: without power this joint is held by nothing"


@dataclass(frozen=True)
class Brake:
    """How one drive's brake is worked: ``others`` are the other bits of its outputs, None where
    there is no brake to set; ``ours``: nobody but us closes it."""

    others: int | None = None
    ours: bool = False


def take_brake(remote: Remote, drive: Drive) -> tuple[Brake, list[str]]:
    """The drive's brake, and what to know of it. It is set: nothing is powered yet."""
    if not drive.brake:
        return Brake(), [NONE]
    value = remote.read(OUTPUTS, PHYSICAL) or 0
    if remote.write(OUTPUTS, value | SET_BRAKE, PHYSICAL) is not None:
        return Brake(), [OWN_AFFAIR]
    ours = bool((remote.read(OUTPUTS, MASK) or 0) & SET_BRAKE)
    return Brake(value & ~SET_BRAKE, ours), []


class Brakes:
    """``brakes``: one for each axis, as ``take_brake`` found them; ``deceleration`` of the drives'
    own ramps, rad/s²; ``set_output(axis, value)`` sends a new output, ``taken`` hears that a drive
    has it."""

    def __init__(
        self,
        brakes: list[Brake],
        deceleration: list[float],
        set_output: Callable[[int, int], None],
        on_silence: Callable[[int], None] = lambda axis: None,
    ) -> None:
        self._brakes, self._deceleration = brakes, deceleration
        self._set_output, self._on_silence = set_output, on_silence
        self._axes = [k for k, brake in enumerate(brakes) if brake.others is not None]
        n = len(brakes)
        self._set = [True] * n
        self._asked, self._told = [0.0] * n, [0.0] * n  # s, first and last time of asking for it
        self._taken: list[float | None] = [0.0] * n  # s, when the drive confirmed what it is told
        self._last: tuple[float, Array] | None = None  # s and rad
        self._speed = np.zeros(n)
        self._now = 0.0

    def let_pass(
        self,
        words: list[int],
        statuses: list[int],
        now: float,
        q: Array,
        cut: Collection[int] = (),
    ) -> list[int]:
        """The controlwords that may go out at ``now`` s: power stays until the brake holds.

        q: (n,) where the axes are, rad; cut: axes whose power does worse than none, which goes at
        once, whatever their brakes do.
        """
        if not self._axes:
            return words
        self._pass(now)
        self._see(q)
        allowed = list(words)
        for axis in self._axes:
            if axis in cut:
                self._turn(axis, True)
                allowed[axis] = Control.DISABLE_VOLTAGE  # whoever switches off the others
            else:
                allowed[axis] = self._allowed(axis, words[axis], statuses[axis] & 0x6F)
            self._insist(axis)
        return allowed

    def taken(self, axis: int) -> None:
        """The drive has confirmed an output."""
        if self._taken[axis] is None:
            self._taken[axis] = self._now

    def set_all(self) -> None:
        """Whatever else is going on."""
        for axis in self._axes:
            self._turn(axis, True)

    def _allowed(self, axis: int, word: int, state: int) -> int:
        if state == ENABLED and word == Control.ENABLE:
            self._turn(axis, False)
        elif state == ENABLED and word != Control.QUICK_STOP:
            self._turn(axis, True)
            return word if self._holds(axis) else Control.ENABLE
        elif state in (ENABLED, IN_QUICK_STOP, REACTING):  # it brings its axis to rest by itself
            if self._brakes[axis].ours and state != ENABLED:
                return self._close_at_rest(axis, word, state)
        else:
            self._turn(axis, True)
        return word

    def _close_at_rest(self, axis: int, word: int, state: int) -> int:
        """Nobody else closes this brake: it falls in as the axis comes to rest, and power that a
        quick stop leaves on goes only then."""
        if abs(self._speed[axis]) <= CLOSES_IN * self._deceleration[axis]:
            self._turn(axis, True)
        if state == REACTING:
            return word
        holds = self._set[axis] and self._holds(axis)
        return Control.DISABLE_VOLTAGE if holds else Control.QUICK_STOP

    def _holds(self, axis: int) -> bool:
        """Whether a brake that was told to close does, or nobody can wait any longer."""
        taken = self._taken[axis]
        if taken is None:
            return self._now - self._asked[axis] >= GIVEN_UP
        return self._now - taken >= CLOSES_IN - 1e-9

    def _pass(self, now: float) -> None:
        """Time in which nobody told anything, as after a fault until the reset, is no silence of
        a drive that had not confirmed by then: it is told once more before it is waited for."""
        if (unasked := now - self._now) > AGAIN:
            self._asked = [asked + unasked for asked in self._asked]
        self._now = now

    def _see(self, q: Array) -> None:
        if self._last is not None and self._now > self._last[0]:
            self._speed = (q - self._last[1]) / (self._now - self._last[0])
        self._last = self._now, q.copy()

    def _turn(self, axis: int, closed: bool) -> None:
        if self._set[axis] == closed:
            return
        self._set[axis], self._taken[axis] = closed, None
        self._asked[axis] = self._now
        self._tell(axis)

    def _insist(self, axis: int) -> None:
        """A question or an answer may be lost; who has not confirmed is told again."""
        if self._taken[axis] is not None or self._asked[axis] == -inf:
            return
        if self._now - self._asked[axis] >= GIVEN_UP:
            self._on_silence(axis)
            self._asked[axis] = -inf  # told once
        elif self._now - self._told[axis] >= AGAIN - 1e-9:
            self._tell(axis)

    def _tell(self, axis: int) -> None:
        self._told[axis] = self._now
        others = self._brakes[axis].others or 0
        self._set_output(axis, others | (SET_BRAKE if self._set[axis] else 0))
