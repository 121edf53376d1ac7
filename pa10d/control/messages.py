"""What the daemon asks of control, parsed once where it arrives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from pa10d.control.gains import PidGains
from pa10d.control.laws import Law
from pa10d.control.live_model import LiveModel
from pa10d.control.mailbox import DESCRIPTORS

Switch = Literal["disconnect", "stop", "reset", "confirm"]

Weights = tuple[tuple[float, ...], tuple[float, ...]]  # of each joint, N·m, least and most


@dataclass(frozen=True)
class FollowRows:
    """Follow rows of sealed memory. rows: its descriptor; first, last: those of the plan itself;
    weight: see ``MotionUnderWay``."""

    number: int
    rows: int
    first: int
    last: int
    weight: Weights | None = None


@dataclass(frozen=True)
class UseLaw:
    """Another control law; model: of all but PID."""

    name: Law
    model: LiveModel | None


@dataclass(frozen=True)
class UseGains:
    """Other gains for every servo from now on; bodies: (n, 10) standard parameters as they were
    felt, which tell what the arm weighs; None: as before."""

    gains: PidGains
    bodies: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class AskErrors:
    """What the drives remember; clear: and have them forget it."""

    clear: bool


@dataclass(frozen=True)
class PowerUp:
    """recover: also where a joint stands outside its position limits, to go back inside."""

    recover: bool


@dataclass(frozen=True)
class PowerDown:
    """anyway: also where brakes do not hold the arm."""

    anyway: bool


@dataclass(frozen=True)
class Connect:
    """stood: where each joint stood at rest, as the daemon has kept it; bodies: (n, 10) standard
    parameters as they were felt, which tell what the arm weighs; None: not known; measured: its
    joints were, by which it is known that their torque acts the right way round; doubted: but of
    these, from 1, something has spoken against that since."""

    stood: tuple[float, ...] | None
    bodies: NDArray[np.float64] | None = None
    measured: bool = False
    doubted: tuple[int, ...] = ()


@dataclass(frozen=True)
class Do:
    """What needs no more than its name."""

    what: Switch


Command = FollowRows | UseLaw | UseGains | AskErrors | PowerUp | PowerDown | Connect | Do


def read_command(message: Mapping[str, Any]) -> Command:
    """ValueError, KeyError or TypeError where it is none."""
    match message.get("do"):
        case "run":
            number, first, last = (int(message[key]) for key in ("number", "first", "last"))
            (rows,) = message[DESCRIPTORS]
            return FollowRows(number, rows, first, last, _weight(message))
        case "controller":
            name: Law = message["name"]
            return UseLaw(
                name, None if name == "pid" else LiveModel.from_document(message["model"])
            )
        case "gains":
            return UseGains(PidGains.from_document(message["gains"]), _bodies(message))
        case "errors":
            return AskErrors(bool(message.get("clear")))
        case "connect":
            stood = message.get("stood")
            kept = None if stood is None else tuple(map(float, stood))
            doubted = tuple(map(int, message.get("doubted", ())))
            return Connect(kept, _bodies(message), bool(message.get("measured")), doubted)
        case "enable":
            return PowerUp(bool(message.get("recover")))
        case "disable":
            return PowerDown(bool(message.get("anyway")))
        case what if what in SWITCHES:
            return Do(what)
        case what:
            raise ValueError(f"unknown command {str(what)!r}")


SWITCHES: tuple[Switch, ...] = get_args(Switch)


def _weight(message: Mapping[str, Any]) -> Weights | None:
    known = message.get("weight")
    if known is None:
        return None
    low, high = (tuple(map(float, one)) for one in known)
    return low, high


def _bodies(message: Mapping[str, Any]) -> NDArray[np.float64] | None:
    felt = message.get("bodies")
    return None if felt is None else np.array(felt, dtype=float)
