"""The arm's states, and what may be asked of it in which of them."""

from __future__ import annotations

from enum import IntEnum


class ArmState(IntEnum):
    """offline → inactive (reads only) → enabling → holding → running → stopping → disabling."""

    OFFLINE = 0
    INACTIVE = 1
    HOLDING = 2
    RUNNING = 3
    STOPPING = 4
    FAULT = 5
    ENABLING = 6
    DISABLING = 7
    RESETTING = 8

    @property
    def label(self) -> str:
        """As clients see it."""
        return self.name.lower()


POWERED = frozenset(
    {ArmState.ENABLING, ArmState.HOLDING, ArmState.RUNNING, ArmState.STOPPING, ArmState.DISABLING}
)
"""The only states in which a torque other than zero may leave; the envelope is watched in each."""

SWITCHING = frozenset({ArmState.ENABLING, ArmState.DISABLING, ArmState.RESETTING})
"""Passed through: they end by themselves, in another state or a fault."""

EACH = 8.0  # s that enabling may take more for each brake that opens alone

REMEDIES = {
    ArmState.OFFLINE: "connect the robot: check bus and drives, then ask for 'connect'",
    ArmState.INACTIVE: "enable the arm",
    ArmState.HOLDING: "disable the arm",
    ArmState.RUNNING: "wait for the motion to end, or stop it",
    ArmState.STOPPING: "wait until the arm is at rest",
    ArmState.FAULT: "remove the cause, then reset",
    ArmState.ENABLING: "wait until the arm is held, or stop it",
    ArmState.DISABLING: "wait until the brakes are on and the power is off",
    ArmState.RESETTING: "wait until the drives have acknowledged",
}


class Refused(Exception):
    """A command that does not fit the state: what was asked, the state, the states needed."""

    def __init__(
        self, command: str, state: ArmState, needed: tuple[ArmState, ...], why: str = ""
    ) -> None:
        self.command, self.state, self.needed = command, state, needed
        self.remedy = why or REMEDIES[state]
        wanted = " or ".join(s.label for s in needed)
        reason = f"the arm is {state.label}, needed: {wanted}; {self.remedy}"
        super().__init__(f"{command}: {why if state in needed else reason}")


def require(command: str, state: ArmState, *needed: ArmState, stopped_by: str = "") -> None:
    """Raise Refused unless ``state`` is one of ``needed``. stopped_by: the fault that stops an arm,
    if one does: rest is not what has to be waited for."""
    if state not in needed:
        why = stopped_by if state in (ArmState.STOPPING, ArmState.DISABLING) else ""
        why = "there is no fault to leave" if command == "reset" else why
        raise Refused(command, state, needed, why)
