"""The brake of a drive as one of its outputs (0x60FE:1, bit 0): set before power goes, released
under power only.

Most drives work their brakes by themselves and ignore the bit; whether it acts is the mask's affair
(0x60FE:2), which is left as it is: a brake that hangs on us alone would stay open when we die.
"""

from __future__ import annotations

from collections.abc import Callable

from backends.canopen_cia402.remote import Remote
from backends.cia402 import Control
from pa10d.profile import Drive

OUTPUTS, PHYSICAL, MASK, SET_BRAKE = 0x60FE, 1, 2, 1
ENABLED, STOPPING = 0x27, (0x07, 0x0F)  # bits of a statusword, see cia402.STATUS_BITS
CLOSES_IN = 0.15  # s from a set output to a brake that holds; until then the drive does

OWN_AFFAIR = (
    "no Digital outputs (0x60FE): the drive alone works its brake; see on the arm that it closes "
    "before power goes"
)
ON_US_ALONE = (
    "Digital outputs (0x60FE): its mask gives the brake to the control PC, and nobody sets it when "
    "that dies: have the drive set this output by itself on a fault"
)
NONE = "no brake by the profile: without power this joint is held by nothing"


def take_brake(remote: Remote, drive: Drive) -> tuple[int | None, list[str]]:
    """The other bits of the drive's outputs, None where there is no brake to set, and what to know.

    The brake is set: nothing is powered yet.
    """
    if not drive.brake:
        return None, [NONE]
    value = remote.read(OUTPUTS, PHYSICAL) or 0
    if remote.write(OUTPUTS, value | SET_BRAKE, PHYSICAL) is not None:
        return None, [OWN_AFFAIR]
    masked = (remote.read(OUTPUTS, MASK) or 0) & SET_BRAKE
    return value & ~SET_BRAKE, [ON_US_ALONE] if masked else []


class Brakes:
    """``outputs``: one for each axis, as ``take_brake`` found them; ``set_output(axis, value)``
    sends a new one."""

    def __init__(self, outputs: list[int | None], set_output: Callable[[int, int], None]) -> None:
        self._outputs, self._set_output = outputs, set_output
        self._axes = [k for k, other in enumerate(outputs) if other is not None]
        self._set = [True] * len(outputs)
        self._since = [0.0] * len(outputs)  # s, when it was set last

    def let_pass(self, words: list[int], statuses: list[int], now: float) -> list[int]:
        """The controlwords that may go out at ``now`` s: power stays until the brake holds."""
        if not self._axes:
            return words
        allowed = list(words)
        for axis in self._axes:
            state, word = statuses[axis] & 0x6F, words[axis]
            if state == ENABLED and word == Control.ENABLE:
                self._turn(axis, False, now)
            elif state == ENABLED and word in (Control.SWITCH_ON, Control.SHUTDOWN):
                self._turn(axis, True, now)
                if now - self._since[axis] < CLOSES_IN - 1e-9:
                    allowed[axis] = Control.ENABLE
            elif state not in STOPPING:  # a drive that brings its axis to rest is not disturbed
                self._turn(axis, True, now)
        return allowed

    def set_all(self, now: float) -> None:
        """Whatever else is going on."""
        for axis in self._axes:
            self._turn(axis, True, now)

    def _turn(self, axis: int, closed: bool, now: float) -> None:
        if self._set[axis] == closed:
            return
        self._set[axis], self._since[axis] = closed, now
        self._set_output(axis, (self._outputs[axis] or 0) | (SET_BRAKE if closed else 0))
