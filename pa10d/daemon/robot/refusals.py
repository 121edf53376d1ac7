"""Why the robot does not do what it is asked to, with what would help."""

from __future__ import annotations

from pa10d.control.faults import Fault
from pa10d.control.states import ArmState
from pa10d.daemon.offline import SLOW
from pa10d.daemon.processes.link import Message

UNPOWERED = ("inactive", "offline")  # states in which a profile may change that moves the arm


class CommandRefused(Exception):
    """Control said no: its answer has ``detail`` and, mostly, ``state``, ``needed``, ``remedy``."""

    def __init__(self, answer: Message) -> None:
        super().__init__(answer.get("detail", "refused"))
        self.answer = answer


def still_in_fault(state: str, fault: Fault | None) -> Message:
    """A reset was of no use."""
    return {
        "ok": False,
        "command": "reset",
        "state": state,
        "needed": [ArmState.FAULT.label],
        "detail": f"reset: {fault.sentence if fault else 'the fault persists'}",
        "remedy": fault.remedy if fault else "remove the cause, then reset",
    }


def not_unpowered(state: str, why_offline: str) -> Message:
    """A profile that moves the arm changes while it is unpowered only."""
    starting = state in UNPOWERED
    detail = f"the arm is {state}" + (f": {why_offline}" if starting else "")
    return {
        "state": state,
        "needed": list(UNPOWERED),
        "detail": f"profile: {detail}",
        "remedy": "wait until control has started" if starting else "disable the arm first",
    }


def stands_outside(do: str, state: str, why: str) -> Message:
    """A joint is outside its position limits; why: says how to get back, too."""
    return {"state": state, "needed": [state], "detail": f"{do}: {why}", "remedy": why}


def not_believed(do: str, state: str, why: str) -> Message:
    """A joint reads elsewhere than it stood; why: says what to do, too."""
    return {"state": state, "needed": [state], "detail": f"{do}: {why}", "remedy": why}


def still_powered(state: str, why: str) -> Message:
    """Brakes do not hold the arm; why: says what to do, too."""
    needed = [ArmState.HOLDING.label]
    return {"state": state, "needed": needed, "detail": f"disable: {why}", "remedy": why}


def not_to_be_held(state: str, why: str) -> Message:
    """The profile's gains would not hold the arm; why: says what to do, too."""
    return {"state": state, "needed": [state], "detail": f"enable: {why}", "remedy": why}


def being_started(do: str, state: str) -> Message:
    """Nobody is on the bus yet: what would be said of its silence is no news of a drive."""
    return _unheard(do, state, "the drives are being started", "wait a few seconds, then ask again")


def no_virtual_arm(do: str, state: str, why: str) -> Message:
    """It was refused where it was started, in words of its own; or it is still to come."""
    if why == SLOW:
        return _unheard(do, state, why, "wait until it is there: it is used then")
    remedy = "mend that, then begin 'pa10d serve' anew"
    return _unheard(do, state, f"there is no virtual arm: {why}", remedy)


def no_control(do: str, state: str, why_offline: str, kept: bool) -> Message:
    """There is no control process; kept: there will be one."""
    remedy = (
        "wait a few seconds, then look at the robot's state again"
        if kept
        else "add 'drives' to the profile, one entry per joint"
    )
    return _unheard(do, state, why_offline, remedy)


def _unheard(do: str, state: str, why: str, remedy: str) -> Message:
    return {
        "ok": False,
        "command": do,
        "state": state,
        "needed": [ArmState.INACTIVE.label],
        "detail": f"{do}: {why}",
        "remedy": remedy,
    }
