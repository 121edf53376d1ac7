"""Profiles: one YAML file describes one robot.

A profile is validated when it is loaded. Every wrong or missing value is one line:
file, line, key, what was found, what is expected. Unknown keys are refused.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from pa10d.common.fieldtypes import (
    Counted,
    Factory,
    Height,
    Inertia,
    Nonzero,
    NotNegative,
    Number,
    Positive,
    Range,
    Size,
    Text,
    Turns3,
    Vector3,
    at_least,
)
from pa10d.common.jsonable import JsonObject
from pa10d.common.urdf_xml import MOST_SPEED, MOST_TORQUE
from pa10d.common.yamlfile import Location, several


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


# No arm has more, or less; what a wrong unit or a slip of the pen makes of it is refused.
Speed = Annotated[Positive, Field(le=MOST_SPEED), at_least(1e-3)]  # rad/s
Acceleration = Annotated[Positive, Field(le=1e5), at_least(1e-3)]  # rad/s²
Torque = Annotated[Positive, Field(le=MOST_TORQUE), at_least(1e-4)]  # N·m
Error = Annotated[Positive, Field(le=3.2), at_least(1e-4)]  # rad: half a turn
TorqueRate = Annotated[Positive, Field(le=1e9), at_least(1e-3)]  # N·m/s
Counts = Annotated[Positive, Field(le=1e12), at_least(100)]
Gear = Annotated[Positive, Field(le=1e5), at_least(1e-3)]
Rated = Annotated[Positive, Field(le=1e5), at_least(1e-5)]  # N·m
Believed = Annotated[Positive, Field(le=10), at_least(0.1)]
Offset = Annotated[Number, Field(ge=-1e4, le=1e4)]  # rad
Mass = Annotated[Positive, Field(le=1e4)]  # kg
Rate = Annotated[Positive, Field(le=2000), at_least(20)]  # Hz
Bandwidth = Annotated[Positive, at_least(0.01)]  # Hz
Gain = Annotated[NotNegative, Field(le=1e8)]
Stiffness = Annotated[Positive, Field(le=1e8)]
LONGEST_SILENCE = 0.5  # s without news that a profile may let an arm go on
LONGEST_BEAT = 200  # ms: a drive waits 2.5 of them for a control PC that has died
MOST_BOXES = 200  # each is looked at in every pose of a plan: with so many one takes 10 s


class Base(_Strict):
    """How the arm is mounted: world gravity is (0, 0, -9.81) and the base is turned by rpy, rad."""

    rpy: Turns3 = (0.0, 0.0, 0.0)


class Tool(_Strict):
    """A known body rigidly attached to the last link (its frame: the last joint's frame)."""

    mass: Mass
    com: Vector3 = (0.0, 0.0, 0.0)
    inertia: Inertia = (0.0,) * 6  # about the centre of mass: Ixx Iyy Izz Ixy Ixz Iyz


class Box(_Strict):
    """A solid that the arm must not meet, placed as a URDF places one, in the base frame."""

    size: Size  # m, whole lengths along its own axes
    xyz: Vector3  # m, its centre
    rpy: Turns3 = (0.0, 0.0, 0.0)  # rad
    name: Text | None = None


class Environment(_Strict):
    """What stands around the arm, in the frame of its base (a turned base takes it along)."""

    floor: Height = 0.0  # m along the base's z axis, or none
    boxes: Annotated[list[Box], Field(max_length=MOST_BOXES)] = []


class Limits(_Strict):
    """Per joint; whatever is absent comes from the URDF (acceleration has no place there)."""

    position: list[Range] | None = None  # rad, lower and upper
    velocity: list[Speed] | None = None  # rad/s
    acceleration: list[Acceleration] | None = None  # rad/s²
    torque: list[Torque] | None = None  # N·m at the joint side


Risk = Literal["unwatched", "unknown_reaction", "brake_on_us"]
"""What a drive may lack and a profile may take upon itself: ``unwatched``, it does not notice that
the control PC died (no 0x1016 and no node guarding); ``unknown_reaction``, what it does then cannot
be chosen (no 0x6007); ``brake_on_us``, its brake is closed by the control PC alone
(0x60FE:2) and stays open when that dies."""


class Drive(_Strict):
    """One CiA 402 amplifier and how its numbers become joint-side SI units."""

    node: Annotated[int, Field(strict=True, ge=1, le=127)]
    counts_per_rev: Counts  # encoder counts per *joint* revolution
    rated_torque: Rated  # N·m at the motor: the unit of 0x6076, per mille in 0x6071/0x6077
    gear_ratio: Gear = 1.0
    torque_gain: Believed = 1.0  # N·m that the drive calls so for one true one: a known weight's
    sign: Literal[1, -1] = 1
    zero_offset: Offset = 0.0  # rad: q = sign · counts · 2π/counts_per_rev - zero_offset
    brake: Annotated[bool, Field(strict=True)] = True
    eds: Text | None = None  # relative to the profile; default: the package's own EDS
    vendor_id: Annotated[int, Field(strict=True, ge=0, lt=2**32)] | None = None  # 0x1018:1
    product_code: Annotated[int, Field(strict=True, ge=0, lt=2**32)] | None = None  # 0x1018:2
    heartbeat_ms: Annotated[int, Field(strict=True, ge=10, le=LONGEST_BEAT)] = 100
    accepted_risks: list[Risk] = []  # without them a drive that has one is not powered


class Can(_Strict):
    """The bus, as python-can opens it."""

    interface: Text = "virtualbus"
    channel: Text = "pa10d"
    bitrate: Annotated[int, Field(strict=True, ge=10_000, le=1_000_000)] = 1_000_000
    sdo_reserve: Annotated[float, Field(strict=True, ge=0, lt=0.5)] = 0.02  # share of the wire


class Gains(_Strict):
    """PID gains per joint, N·m/rad, N·m/(rad·s), N·m·s/rad; absent: from the stated rule."""

    kp: list[Stiffness] | None = None
    ki: list[Gain] | None = None
    kd: list[Gain] | None = None


BANDWIDTH = 4.0  # Hz
BANDWIDTH_SHARE = BANDWIDTH / 500.0  # of the loop's rate: a slower loop's answer comes later
MOST_BANDWIDTH = 1.0 / 100.0  # of the loop's rate: with more, some pose of the PA10 swings up


class Control(_Strict):
    """The fixed-rate loop."""

    rate: Rate = 500.0  # Hz
    controller: Literal["pid", "computed_torque"] = "pid"
    bandwidth_hz: Bandwidth | None = None  # closed-loop natural frequency of the gain rule
    gains: Gains = Gains()

    @property
    def servo_bandwidth(self) -> float:
        """Hz; where the profile does not say: as fast as the loop's own delay allows."""
        return self.bandwidth_hz or min(BANDWIDTH, BANDWIDTH_SHARE * self.rate)


class Safety(_Strict):
    """What the one exit for torque enforces, besides the limits."""

    following_error: list[Error] | None = None  # rad
    torque_rate: list[TorqueRate] | None = None  # N·m/s
    stale_cycles: Annotated[int, Field(strict=True, ge=1)] = 3  # cycles without a fresh PDO


class Simulation(_Strict):
    """What stands behind the virtual drives."""

    plant: Factory = "backends.virtual.plant:build"
    options: JsonObject = {}
    clock: Literal["simulated", "real"] = "real"
    seed: Annotated[int, Field(strict=True, ge=0)] = 0


GainError = Annotated[float, Field(ge=0, lt=1)]
"""Share of its value by which a torque constant (gear ratio and friction-free torque per ampere)
may be off; every parameter in units of torque or mass is as uncertain."""


class Profile(_Strict):
    """One robot. ``path`` and ``urdf`` are absolute once loaded."""

    path: Path = Field(json_schema_extra={"internal": True})  # set by load_profile
    name: Text
    urdf: Path
    joints: list[Text] | None = None
    base: Base | None = None
    gravity: Vector3 | None = None
    tool: Tool | None = None
    home: list[Number] | None = None  # rad (m): where motions begin; absent: zero, or mid-range
    environment: Environment = Environment()
    limits: Limits = Limits()
    drives: list[Drive] | None = None
    torque_constants: list[Nonzero] | None = None  # N·m (joint side) per A
    torque_gain_error: GainError | list[GainError] | None = None  # share; absent: 0.05
    map: list[Text] | None = None  # what recordings call their columns, as --map has it
    backend: Text = "canopen_cia402"
    can: Can = Can()
    control: Control = Control()
    safety: Safety = Safety()
    simulation: Simulation | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Profile:
        problems = [
            *self._gravity_twice(),
            *self._lengths(),
            *self._repeated(),
            *self._too_fast(),
            *self._deaf(),
        ]
        if problems:
            raise several(problems)
        return self

    def per_joint(self) -> dict[Location, list[Any]]:
        """Every list that has one entry per joint, by its place in the file."""
        places: dict[Location, list[Any] | None] = {
            ("joints",): self.joints,
            ("home",): self.home,
            ("drives",): self.drives,
            ("torque_constants",): self.torque_constants,
            ("torque_gain_error",): (
                self.torque_gain_error if isinstance(self.torque_gain_error, list) else None
            ),
        }
        sections: dict[Location, BaseModel] = {
            ("limits",): self.limits,
            ("control", "gains"): self.control.gains,
            ("safety",): self.safety,
        }
        for place, section in sections.items():
            for key, value in section:
                places[(*place, key)] = value if isinstance(value, list) else None
        return {place: value for place, value in places.items() if value is not None}

    def _gravity_twice(self) -> list[tuple[Location, Any, str]]:
        if self.base is None or self.gravity is None:
            return []
        return [(("gravity",), self.gravity, "either 'base' or 'gravity', not both")]

    def _too_fast(self) -> list[tuple[Location, Any, str]]:
        """Gains for a servo that its loop is too slow for: it would swing up."""
        asked, most = self.control.bandwidth_hz, MOST_BANDWIDTH * self.control.rate
        if asked is None or asked <= most:
            return []
        wanted = f"at most {most:g}, a hundredth of the loop's rate: with more it would swing up"
        return [(("control", "bandwidth_hz"), asked, wanted)]

    def _deaf(self) -> list[tuple[Location, Any, str]]:
        """A joint that goes on without news of where it is."""
        asked, most = self.safety.stale_cycles, int(LONGEST_SILENCE * self.control.rate)
        if asked <= most:
            return []
        wanted = f"at most {most}: {LONGEST_SILENCE:g} s at {self.control.rate:g} Hz"
        return [(("safety", "stale_cycles"), asked, wanted)]

    def _lengths(self) -> list[tuple[Location, Any, str]]:
        """All per-joint lists are as long as the first one (the joints, where they are named)."""
        lists = self.per_joint()
        if not lists:
            return []
        first, n = next((place, len(value)) for place, value in lists.items())
        wanted = f"{Counted(n)}, one per joint as in '{'.'.join(map(str, first))}'"
        found = [
            (place, Counted(len(value)), wanted)
            for place, value in lists.items()
            if len(value) != n
        ]
        return found if n else [*found, (first, Counted(0), "at least one entry")]

    def _repeated(self) -> list[tuple[Location, Any, str]]:
        names = self.joints or []
        nodes = [drive.node for drive in self.drives or []]
        return [
            (("joints", k), name, "joint names that differ")
            for k, name in enumerate(names)
            if name in names[:k]
        ] + [
            (("drives", k, "node"), node, f"node ids that differ (drive {nodes.index(node) + 1})")
            for k, node in enumerate(nodes)
            if node in nodes[:k]
        ]
