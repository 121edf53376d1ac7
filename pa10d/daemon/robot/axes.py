"""What the axes of an arm said last, for clients."""

from __future__ import annotations

import numpy as np

from backends.device import Device
from pa10d.control.ring import Ring
from pa10d.daemon.processes.link import Message
from pa10d.dynamics import Robot
from pa10d.profile import Profile

SILENT = 0.5  # s of the loop's time


def axes_of(ring: Ring, robot: Robot, profile: Profile, state: str) -> list[Message]:
    """One entry a joint, from 1; none where the arm is offline or nothing was said yet."""
    last, get = ring.last(), ring.layout.get
    if state == "offline" or last is None:
        return []
    return [
        {
            "joint": j + 1,
            "name": name,
            "position": float(get(last, "q")[j]),
            "velocity": float(get(last, "dq")[j]),
            "torque": float(get(last, "tau")[j]),
            "target": float(get(last, "q_ref")[j]),
            "temperature": _finite(get(last, "temperature")[j]),
            "status_word": int(get(last, "status")[j]),
            "age": int(get(last, "age")[j]),
            "silent": is_silent(int(get(last, "age")[j]), profile, state),
        }
        for j, name in enumerate(robot.joint_names)
    ]


def is_silent(age: int, profile: Profile, state: str) -> bool:
    """Whether what an axis said last, this many cycles ago, is no news any more; in a fault
    sooner, for there its silence may be the cause."""
    latest = SILENT * profile.control.rate
    if state == "fault":
        latest = min(latest, profile.safety.stale_cycles)
    return age >= latest


def remarks_of(words: Device, axes: list[Message]) -> list[str]:
    """What drives say beside their states, now."""
    return [
        f"joint {axis['joint']}: {remark}"
        for axis in axes
        for remark in words.remarks(axis["status_word"])
    ]


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
