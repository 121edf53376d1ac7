"""The arm as it stands, its drives, and who may move it."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from pa10d.api.schemas.common import Name, Strict
from pa10d.control.laws import Law
from pa10d.services.viewed import Joint

StateName = Literal[
    "offline", "inactive", "enabling", "holding", "running", "stopping", "disabling", "fault",
    "resetting",
]  # fmt: skip


class Fault(BaseModel):
    """A latched fault."""

    kind: str = Field(examples=["following_error"])
    cause: str
    joint: int | None = Field(description="None: the whole arm")
    remedy: str
    sentence: str
    state: str = Field(description="The arm's state when it happened")
    time: float
    sequence: int
    device: bool = Field(description="Said by a drive or the bus, not by the loop")
    hertz: float = Field(0.0, description="Hz of an oscillation, else 0")
    was_there: bool = Field(
        False, description="The joint had been where it should go, so nothing bars that way"
    )


class Axis(BaseModel):
    """One joint, now."""

    joint: Joint
    name: str
    position: float = Field(description="rad")
    velocity: float = Field(description="rad/s")
    torque: float = Field(description="N·m, measured")
    target: float = Field(description="rad, where it shall be")
    temperature: float | None = Field(description="°C")
    status_word: int = Field(description="CiA 402 0x6041")
    drive_state: str | None = Field(
        None, description="CiA 402 state", examples=["switch on disabled"]
    )
    age: int = Field(description="Cycles since it answered")
    silent: bool = Field(description="It does not answer: its values are no news")


class Outside(BaseModel):
    """A joint that stands outside its position limits."""

    joint: Joint
    position: float = Field(description="rad")
    limit: float = Field(description="rad, the one that it is beyond")
    beyond: float = Field(description="rad")
    too_far: bool = Field(description="Not even powered to go back: it is moved by hand")
    sentence: str


class Misplaced(BaseModel):
    """A joint that reads elsewhere than it stood before its drive was set up anew."""

    joint: Joint
    was: float = Field(description="rad, where it stood when it was heard last")
    reads: float = Field(description="rad, now")
    sentence: str


class EnableRequest(Strict):
    """How the arm is powered."""

    recover: bool = Field(
        False,
        description="Where joints stand outside their position limits: power the arm all the same "
        "and bring them back inside, slowly. Without it that is refused",
    )


class Unheld(BaseModel):
    """A joint that its brake did not hold as the arm was left to its brakes."""

    joint: Joint
    gone: float = Field(description="rad (m), in its closed brake, until its motor held it again")
    unit: str = Field(examples=["rad"])
    sentence: str


class DisableRequest(Strict):
    """How power is taken from the arm."""

    anyway: bool = Field(
        False,
        description="Also where a brake does not hold the arm: it sinks. Without it power stays "
        "there, and that is said",
    )


class Lease(BaseModel):
    """Who commands the arm."""

    holder: str | None = Field(examples=["anonymous@127.0.0.1"])
    expires_in: float = Field(description="s")


class RobotState(BaseModel):
    """The arm, now."""

    profile: str
    state: StateName
    fault: Fault | None
    offline_reason: str | None
    offline_passes: bool = Field(description="It is offline, and needs nothing but some seconds")
    controller: Law
    model: str | None = Field(description="The model that the control law uses")
    model_parameters: Literal["feasible", "free"] | None = Field(
        default=None, description="Of which fit: bodies that can exist, or the free one"
    )
    rate: float = Field(description="Hz")
    simulated: bool
    notes: list[str] = Field(description="What this machine does not allow, and what that means")
    recording: bool = Field(description="What the arm does now belongs to a run")
    time: float | None = Field(description="s on the loop's clock")
    quiet: float = Field(
        description="s since the control process last gave a sign of life; all else is that old"
    )
    axes: list[Axis]
    outside: list[Outside] = Field(description="Joints outside their position limits")
    misplaced: list[Misplaced] = Field(
        description="Joints that are not powered before somebody has looked (confirm)"
    )
    unheld: list[Unheld] = Field(
        description="Joints that their brakes did not hold as power was to go, so that it stayed"
    )
    lease: Lease


class DriveError(BaseModel):
    """One error that a drive remembers."""

    code: int = Field(description="CiA 301/402", examples=[0x2310])
    words: str = Field(examples=["0x2310 (overcurrent)"])
    of_the_maker: int = Field(description="Upper 16 bits of the entry: the drive's manual")


class DriveMemory(BaseModel):
    """What one drive tells of its errors; null where it has no such object."""

    joint: int = Field(description="From 1")
    name: str
    register_: int | None = Field(alias="register", description="0x1001, bits of what is wrong now")
    wrong_now: list[str] = Field(description="The same in words", examples=[["generic error"]])
    error: DriveError | None = Field(description="0x603F")
    history: list[DriveError] | None = Field(description="0x1003, the newest first")
    problem: str | None = Field(description="Why it could not be asked, or emptied")


class DriveMemories(BaseModel):
    """What the drives remember."""

    drives: list[DriveMemory]


class LeaseRequest(Strict):
    """Ask for the command of the arm."""

    seconds: float = Field(60.0, gt=0, le=3600)


class ControllerRequest(Strict):
    """Which control law holds and moves the arm from now on."""

    controller: Law
    model: Name | None = None


class Health(BaseModel):
    """Is the daemon alive, and does the robot answer?"""

    status: Literal["ok"] = "ok"
    version: str
    robot: StateName
    uptime: float = Field(description="s")
