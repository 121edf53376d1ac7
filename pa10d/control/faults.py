"""What went wrong, on which axis, and what to check first."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from numbers import Integral
from typing import Any

from backends.protocol import BackendFault
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.control.guard import BackendBroke
from pa10d.control.punctuality import Starved

WAY_ROUND = (
    "exchange two phases of its motor, or the drive's polarity (0x607E); 'sign' in the profile "
    "turns angle and torque together and does not mend this"
)
IF_WRONG_WAY = f"look at its load first; where its torque does act the wrong way round, {WAY_ROUND}"
RAN_ON = (
    "got faster as its own drive stopped it, and was left to its brake: its torque acts the wrong "
    "way round, or its load is more than its motor holds"
)
RAN_ON_RIGHTLY = (
    "got faster as its own drive stopped it, and was left to its brake: what others do to it, or "
    "its load, is more than its motor holds"
)
UNSEEN = (
    "its power was taken away at once, for nobody has seen yet that its torque acts the right way "
    "round, and its drive's own ramp would drive it on"
)
REMEDIES = {
    "not_finite": "report it with the recorded run; look at gains and model first",
    "torque_state": "report it: torque was asked for in a state that allows none",
    "position_limit": "look at the plan and at what pushes the arm; move it back inside by hand",
    "velocity_limit": "look at the plan's speeds, the gains and the drive's sign and gear ratio",
    "following_error": "look for a collision, a brake that drags, wrong sign, weak gains, "
    "a payload or a mount (base.rpy) that nobody described",
    "not_held": "look at this joint's sign, gear_ratio and rated_torque, at its brake and payload; "
    "where these are right, and it is held in a pose in which gravity does little on it, the "
    "URDF's masses or centres from this joint on are wrong, or base.rpy: correct them",
    "oscillation": "its gains do not fit it: run the experiment first_motion, which measures the "
    "joints and sets them, or lower control.bandwidth_hz",
    "brake_gave": "look at this joint's brake, and whether brakes that hang on one output open "
    "together: from now on all of them open at once",
    "brake_slips": "keep away from the arm and prop it up; look at this joint's brake: worn, oily, "
    "held open by hand or by its wiring, or too small for what hangs on it",
    "wrong_sign": WAY_ROUND,
    "stale": "check cabling, termination and bus load; the axis stopped answering",
    "no_number": "look at what this backend reads; the drive's encoder and its scaling",
    "backend": "report it to whoever wrote this backend, with the daemon's log; 'reset' tries anew",
    "controller": "report it with the recorded run; the arm was stopped by the joint servo",
    "switching": "look at supply, safe-torque-off and brakes: the drives did not do as asked",
    "stop": "look at brakes and drives before the next motion: the arm did not stop as asked",
    "daemon_gone": "look at the daemon's log; systemd starts it again",
}

# of a joint that fell and told what it weighs
WRONG = (
    "the URDF's masses or centres from this joint on are wrong, or the profile's base.rpy, or this "
    "drive's gear_ratio or rated_torque, or, where it falls again and again, its sign: correct them"
)
WEIGHED = f"'reset' and enable again; {WRONG}"


@dataclass(frozen=True)
class Fault:
    """Latched until an explicit reset. ``axis`` is 0-based, None for the whole arm."""

    kind: str
    cause: str
    axis: int | None = None
    remedy: str = ""
    state: str = ""  # the arm's state when it happened
    time: float = 0.0  # s on the loop's clock
    sequence: int = 0  # the record at which it happened; the ring keeps the seconds before
    device: bool = False  # said by the backend
    hertz: float = 0.0  # of an oscillation
    was_there: bool = False  # where it should go, since power-up: nothing bars that way
    weighed: int = 0  # a joint (from 1) whose fall told what holds it: begun with next; 0: none
    alone_next: bool = False  # a fall that told nothing: each brake opens alone from now on

    @property
    def dead_axis(self) -> int | None:
        """The axis that takes no torque any more."""
        return self.axis if self.device or self.kind == "stale" else None

    @property
    def drive_goes_on(self) -> bool:
        """Whether a dead axis has power, and is to be stopped by a drive that may not be able to:
        it sees what our torque was not to be trusted to."""
        return self.kind == "encoder_jump"

    @property
    def whole_bus(self) -> bool:
        """Whether no axis can be stopped by the loop."""
        return self.device and self.axis is None

    @property
    def runs_away(self) -> bool:
        """Whether the torque itself is what moves an axis that shall stand."""
        return self.kind in ("not_held", "wrong_sign")

    @property
    def opens_together(self) -> bool:
        """Whether all brakes open at once from now on, for one opened with another's."""
        return self.kind == "brake_gave"

    @property
    def opens_otherwise(self) -> bool:
        """Whether the next enabling has brakes opened in another way, and may hold the arm."""
        return self.opens_together or self.alone_next

    @property
    def fell(self) -> bool:
        """Whether a brake has caught a fall, and links may swing on behind it."""
        return self.runs_away or self.opens_together

    @property
    def seen(self) -> str:
        """What was seen, for a person; joints numbered from 1."""
        named = self.axis is None or self.cause.startswith("joint ")
        return ("" if named else f"joint {(self.axis or 0) + 1}: ") + self.cause

    @property
    def sentence(self) -> str:
        """The same, and what to do, in one line."""
        return self.seen + (f"; {self.remedy}" if self.remedy else "")

    @property
    def joint(self) -> int | None:
        """The axis, from 1."""
        return None if self.axis is None else self.axis + 1

    def document(self) -> JsonObject:
        """For JSON: the axis numbered from 1 as ``joint``."""
        out = asdict(self)
        del out["axis"]
        return {**out, "joint": self.joint, "sentence": self.sentence}

    @staticmethod
    def from_document(document: Mapping[str, Any]) -> Fault:
        """The other way; KeyError, TypeError or ValueError where it is none. What an older version
        did not say is as if there was nothing to say."""
        joint = document.get("joint")
        return Fault(
            kind=str(document["kind"]),
            cause=str(document["cause"]),
            axis=None if joint is None else int(joint) - 1,
            remedy=str(document.get("remedy", "")),
            state=str(document.get("state", "")),
            time=float(document.get("time", 0.0)),
            sequence=int(document.get("sequence", 0)),
            device=bool(document.get("device", False)),
            hertz=float(document.get("hertz", 0.0)),
            was_there=bool(document.get("was_there", False)),
            weighed=int(document.get("weighed", 0)),
            alone_next=bool(document.get("alone_next", False)),
        )


class LoopFault(Exception):
    """The loop itself saw what may not go on; the rest is that of a ``Fault``."""

    def __init__(self, kind: str, cause: str, axis: int | None = None, hertz: float = 0.0) -> None:
        super().__init__(cause)
        self.kind, self.cause, self.axis, self.hertz = kind, cause, axis, hertz
        self.was_there, self.weighed = False, 0


LONGEST = 2000  # characters of a cause: it goes through pipe and ring in one piece
FROM_STARVING = {"following_error", "velocity_limit", "position_limit", "not_held", "stale", "stop",
                 "silent"}  # fmt: skip
OF_DRIVES = {"emcy", "drive_fault"}  # where they missed SYNC or our heartbeat


def blamed_on_time(fault: Fault, starved: Starved | None) -> Fault:
    """Of a loop that did not get its time, what it led to is no collision and no loose cable."""
    if starved is None or not (
        fault.kind in FROM_STARVING or (fault.kind in OF_DRIVES and _missed_us(fault.cause))
    ):
        return fault
    cause = f"{starved.cause} ({fault.seen})"
    return replace(fault, kind="starved", cause=cause, axis=None, remedy=starved.remedy)


def _missed_us(cause: str) -> bool:
    return "SYNC" in cause or "heartbeat of the control PC" in cause


def fault_from(error: Exception, n: int, state: str, time: float, sequence: int) -> Fault:
    """Any exception as a fault of an arm of ``n`` joints; what a backend says of itself is taken
    as plain text and numbers, whatever it is."""
    device, axis, hertz = isinstance(error, BackendFault), None, 0.0
    was_there, weighed = False, 0
    if isinstance(error, BackendFault):
        kind, cause, remedy = str(error.kind), str(error.cause), str(error.remedy)
        axis = int(error.axis) if isinstance(error.axis, Integral) else None
        axis = None if axis is None or not 0 <= axis < n else axis
    elif isinstance(error, LoopFault):
        kind, cause, axis, hertz = error.kind, error.cause, error.axis, error.hertz
        was_there, weighed = error.was_there, error.weighed
        remedy = WEIGHED if weighed else REMEDIES[kind]
    elif isinstance(error, BackendBroke | UserError):
        kind, cause, remedy = "backend", str(error), REMEDIES["backend"]
    else:
        kind, cause = "controller", f"{type(error).__name__}: {' '.join(str(error).split())}"
        remedy = REMEDIES[kind]
    cause, remedy = _short(cause), _short(remedy)
    seen = (device, hertz, was_there, weighed)
    return Fault(kind, cause, axis, remedy, state, time, sequence, *seen)


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[:LONGEST]} …"
