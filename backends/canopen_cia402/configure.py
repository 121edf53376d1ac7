"""Bring one drive from PRE-OPERATIONAL to ready for the cycle, and check that it is so."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from math import isfinite, pi

import canopen

from backends import cia402, vendors
from backends.canopen_cia402.brakes import ON_US_ALONE, Brake, take_brake
from backends.canopen_cia402.layout import Layout
from backends.canopen_cia402.lifeline import be_watched
from backends.canopen_cia402.mapping import map_pdos
from backends.canopen_cia402.objects import ESSENTIAL, WANTED, declared, lack
from backends.canopen_cia402.reaction import REACTION, reaction
from backends.canopen_cia402.remote import Remote, SetupError
from backends.canopen_cia402.takeover import (
    clear_offsets,
    contradictions,
    fixed_entries,
    hear_emergencies,
    let_through,
    own_sync,
    untold,
)
from backends.limits import AxisLimits
from backends.scaling import Scaling
from pa10d.profile import Drive, Risk

MODE_TAKES = 0.5  # s at most until 0x6061 shows the mode
DRIVE_SPEED = 1.5
"""Of the velocity limit: what a drive lets its axis do in torque mode. Where pa10d is kept from
its work the last torque goes on until the drive misses SYNC, and speed is what the arm gathers."""
INT32, UINT32 = 2**31 - 1, 2**32 - 1
FIRST_SUB = {0x1029: 1, 0x607D: 1, 0x60C2: 1}  # of what is a record


@dataclass(frozen=True)
class Wish:
    """What a drive shall be told."""

    drive: Drive
    scaling: Scaling
    limits: AxisLimits
    period: float  # s
    bitrate: int
    master: int  # our node id, which heartbeats come from
    silence_ms: int  # the drive stops after this long without one
    trusted: bool = False  # its torque was seen to act the right way round


@dataclass
class DriveReport:
    """What a drive turned out to be."""

    node: int
    name: str
    vendor: int
    product: int
    revision: int
    serial: int
    modes: list[str]
    command: Layout
    feedback: Layout
    error: int  # 0x603F when we came
    position: int | None = None  # counts, in its brake
    shows_mode: bool = True  # by 0x6061
    has_reaction: bool = True  # 0x605E
    heard: bool = True  # it tells that it lives, by heartbeats or when it is asked
    guarded: bool = False  # it is asked by remote frames, as it watches no heartbeat
    risks: dict[Risk, str] = field(default_factory=dict)  # what nobody may overlook; in lacks too
    brake: Brake = field(default_factory=Brake)
    lacks: list[str] = field(default_factory=list)
    fixed: dict[tuple[int, int], int] = field(default_factory=dict)  # what nobody else may change

    @property
    def identity(self) -> str:
        """One line for people."""
        return (
            f"node {self.node}: {self.name or 'unnamed'}, vendor 0x{self.vendor:X}, product "
            f"0x{self.product:X}, revision 0x{self.revision:X}, serial 0x{self.serial:X}"
        )


def configure(node: canopen.RemoteNode, wish: Wish) -> DriveReport:
    """Check and set up one drive by SDO; SetupError names every reason to refuse it."""
    remote = Remote(node)
    _require_usable(remote, wish)
    brake, brake_lacks = take_brake(remote, wish.drive)
    lifeline = be_watched(remote, wish.master, wish.silence_ms, wish.drive.heartbeat_ms)
    risks = dict(lifeline.risks)
    if brake.ours:
        risks["brake_on_us"] = ON_US_ALONE
        brake_lacks = [ON_US_ALONE, *brake_lacks]
    lacks = [*lifeline.lacks, *brake_lacks, *hear_emergencies(remote)]
    lacks += [lack(i) for i in WANTED if not remote.has(i, FIRST_SUB.get(i, 0))]
    lacks += untold(remote)
    lacks += _set_up(remote, wish, brake)
    command, feedback = map_pdos(remote)
    shows_mode = remote.read(0x6061) is not None
    return DriveReport(
        node=node.id,
        name=remote.text(0x1008),
        vendor=remote.read(0x1018, 1) or 0,
        product=remote.read(0x1018, 2) or 0,
        revision=remote.read(0x1018, 3) or 0,
        serial=remote.read(0x1018, 4) or 0,
        modes=cia402.supported_modes(remote.read(0x6502) or 0),
        command=command,
        feedback=feedback,
        error=remote.read(0x603F) or 0,
        position=remote.read(0x6064),
        shows_mode=shows_mode,
        has_reaction=remote.has(REACTION),
        heard=lifeline.heard,
        guarded=lifeline.guarded,
        risks=risks,
        brake=brake,
        lacks=list(dict.fromkeys(lacks)),
        fixed=fixed_entries(remote, shows_mode),
    )


def _require_usable(remote: Remote, wish: Wish) -> None:
    reasons = [
        f"no {name} (0x{index:04X}) in its EDS: not usable as a CiA 402 torque drive"
        for index, name in ESSENTIAL.items()
        if not declared(remote.node, index)
    ]
    kind = remote.read(0x1000)
    if kind is not None and kind & 0xFFFF != 402:
        reasons.append(f"device type 0x{kind:08X} (0x1000) is not CiA 402 (0x....0192)")
    for sub, name, expected in (
        (1, "vendor", wish.drive.vendor_id),
        (2, "product", wish.drive.product_code),
    ):
        found = remote.read(0x1018, sub)
        if expected is not None and found != expected:
            shown = "nothing" if found is None else f"0x{found:X}"
            reasons.append(f"{name} (0x1018:{sub}): found {shown}, profile expects 0x{expected:X}")
    reasons += _mode_reasons(remote)
    reasons += contradictions(remote, wish.drive, _ends(wish))
    rates = remote.node.object_dictionary.device_information.allowed_baudrates
    if rates and wish.bitrate not in rates:
        shown = ", ".join(f"{rate / 1000:g}" for rate in sorted(rates))
        reasons.append(f"its EDS allows {shown} kbit/s, the profile has {wish.bitrate / 1000:g}")
    if not reasons:  # nothing is written to a drive that is refused anyway
        reasons = [*clear_offsets(remote), *own_sync(remote)]
    if reasons:
        raise SetupError(reasons)


def _mode_reasons(remote: Remote) -> list[str]:
    """A drive that does not say what it offers is asked for the mode, and 0x6061 decides."""
    modes = remote.read(0x6502)
    if modes is None or modes & cia402.SUPPORTS_CST:
        return []
    names = ", ".join(cia402.supported_modes(modes)) or "none at all"
    return [
        "no cyclic synchronous torque mode (bit 9 of 0x6502, Supported drive modes): "
        f"the drive offers {names}"
    ]


def _set_up(remote: Remote, wish: Wish, brake: Brake) -> list[str]:
    """Write the settings; the answer lists what did not take."""
    lacks = _choose_quick_stop(remote, brake)
    for index, sub, value in _settings(remote, wish):
        lacks += _not_taken(index, remote.write(index, value, sub))
    most = _most_torque(wish)
    if most is not None and (reasons := let_through(remote, most, wish.scaling.rated)):
        raise SetupError(reasons)
    lacks += _left_to_the_user(remote)
    return lacks + _choose_torque_mode(remote)


def _not_taken(index: int, problem: str | None) -> list[str]:
    """What it means that a setting was not taken, nothing where it was."""
    if problem is None:
        return []
    if problem == "absent":
        return [lack(index)]
    name, meaning = WANTED[index]
    return [f"{name} (0x{index:04X}): {problem}; {meaning}"]


def _choose_quick_stop(remote: Remote, brake: Brake) -> list[str]:
    """Down a ramp, then without power; but with it where the brake has to be closed by us first."""
    wanted = [cia402.QuickStop.QUICK_STOP]
    if brake.ours:
        wanted.insert(0, cia402.QuickStop.STAY_QUICK_STOP)
    for option in wanted:
        if (problem := remote.write(0x605A, option)) is None:
            break
    return _not_taken(0x605A, problem)


def _choose_torque_mode(remote: Remote) -> list[str]:
    """Cyclic synchronous torque, and that the drive shows it; the answer says what it hides."""
    problem = remote.write(0x6060, cia402.MODE_CST)
    shown, end = remote.read(0x6061), time.monotonic() + MODE_TAKES
    while shown not in (None, cia402.MODE_CST) and not problem and time.monotonic() < end:
        time.sleep(0.02)
        shown = remote.read(0x6061)
    if problem or shown not in (None, cia402.MODE_CST):
        raise SetupError(
            [
                f"cyclic synchronous torque not accepted: 0x6060 {problem or 'written'}, "
                f"0x6061 shows {shown}"
            ]
        )
    return [lack(0x6061)] if shown is None else []


def _settings(remote: Remote, wish: Wish) -> list[tuple[int, int, int]]:
    """(index, sub-index, value) of what makes the drive safe and synchronous."""
    limits, scaling = wish.limits, wish.scaling
    settings = [
        (0x1006, 0, round(wish.period * 1e6)),
        (0x1029, 1, 0),
        (0x605C, 0, 1),
        (REACTION, 0, reaction(wish.trusted)),
    ]
    if (most := _most_torque(wish)) is not None:
        settings.append((0x6072, 0, most))
    ends = _ends(wish)
    settings += [(0x607D, 1, ends[0]), (0x607D, 2, ends[1])]
    product = _product(remote)
    if isfinite(limits.acceleration) and product in vendors.DECELERATION_IN_COUNTS:
        settings.append((0x6085, 0, _unsigned(limits.acceleration * scaling.counts_per_radian)))
    if isfinite(limits.velocity) and product in vendors.SPEED_IN_RPM:
        speed = DRIVE_SPEED * limits.velocity * wish.drive.gear_ratio  # rad/s of the motor
        settings.append((0x6080, 0, _unsigned(speed * 60 / (2 * pi))))
    return settings + _cycle_time(wish.period)


def _unsigned(value: float) -> int:
    """In 32 bits; a limit that is beyond them is none to the drive."""
    return min(round(value), UINT32)


def _most_torque(wish: Wish) -> int | None:
    """Per mille of the rated torque, None: no limit is known."""
    if not isfinite(wish.limits.torque):
        return None
    return min(round(1000 * wish.limits.torque / wish.scaling.rated), 0xFFFF)


def _ends(wish: Wish) -> tuple[int, int]:
    """The counts between which the joint moves."""
    one, other = (_counts(wish.scaling, q) for q in (wish.limits.lower, wish.limits.upper))
    return min(one, other), max(one, other)


def _left_to_the_user(remote: Remote) -> list[str]:
    """What the drive has, in a unit that only its manual tells."""
    product = _product(remote)
    known = {
        0x6080: product in vendors.SPEED_IN_RPM,
        0x6085: product in vendors.DECELERATION_IN_COUNTS,
    }
    return [
        f"{WANTED[index][0]} (0x{index:04X}) is left as it is, its unit is its maker's: "
        "set it by the drive's manual"
        for index, settable in known.items()
        if not settable and remote.has(index)
    ]


def _product(remote: Remote) -> tuple[int, int]:
    """Vendor id and product code."""
    return remote.read(0x1018, 1) or 0, remote.read(0x1018, 2) or 0


def _counts(scaling: Scaling, q: float) -> int:
    if not isfinite(q):
        return -INT32 - 1 if q * scaling.sign < 0 else INT32
    return max(-INT32 - 1, min(INT32, scaling.counts(q)))


def _cycle_time(period: float) -> list[tuple[int, int, int]]:
    """0x60C2 where the period can be said as one byte times a power of ten."""
    for exponent in (-3, -4, -5):
        value = period / 10**exponent
        if 0.5 < value < 255.5 and abs(value - round(value)) < 1e-6 * value:
            return [(0x60C2, 1, round(value)), (0x60C2, 2, exponent)]
    return []
