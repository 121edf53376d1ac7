"""What the tests of the bus share: profiles, the virtual arm as a process, a simple controller."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from canopen import Network, RemoteNode
from forked_arm import ForkedArm

from backends import by_hand
from backends.canopen_cia402.backend import CanopenBackend
from backends.eds import OWN_EDS
from backends.frames import frame
from backends.protocol import BackendFault, Feedback
from backends.virtual.drives.injection import Injection
from backends.virtualbus import VirtualBus
from pa10d.profile import Profile, load_profile

HERE = Path(__file__).parent
URDF = HERE.parent.parent / "profiles" / "pa10_7c.urdf"
JOINTS = ["S1", "S2", "S3", "E1", "E2", "W1", "W2"]
_number = count()


def make_profile(folder: Path, axes: int = 3, **changes: Any) -> Profile:
    """A profile of pendulums on a virtual bus of its own; ``drive`` changes every drive,
    ``each`` the drives of its keys."""
    drive = {"counts_per_rev": 819200, "gear_ratio": 50, "rated_torque": 2.0}
    drive |= changes.pop("drive", {})
    each = changes.pop("each", {})
    document: dict[str, Any] = {
        "urdf": str(URDF),
        "joints": JOINTS[:axes],
        "limits": {
            "position": [[-3.0, 3.0]] * axes,
            "velocity": [6.0] * axes,
            "acceleration": [20.0] * axes,
            "torque": [100.0] * axes,
        },
        "drives": [{"node": 10 + k, **drive, **each.get(k, {})} for k in range(axes)],
        "can": {"interface": "virtualbus", "channel": f"t{os.getpid()}-{next(_number)}"},
        "control": {"rate": 200.0},
        "simulation": {"plant": "pendulums:build", "clock": "simulated"},
    }
    for key, value in changes.items():
        document[key] = {**document.get(key, {}), **value} if isinstance(value, dict) else value
    path = folder / "robot.yaml"
    path.write_text(yaml.safe_dump(document))
    return load_profile(path)


def patient_eds(folder: Path, milliseconds: int = 1000) -> str:
    """Our drive, but one that waits longer for a SYNC: for machines that keep no deadlines."""
    text = OWN_EDS.read_text()
    at = text.index("[2F01]")
    path = folder / "patient.eds"
    path.write_text(
        text[:at] + text[at:].replace("DefaultValue=200", f"DefaultValue={milliseconds}", 1)
    )
    return str(path)


def own_eds_without(folder: Path, *indices: int) -> Path:
    """Our drive, but one that lacks these objects."""
    text = OWN_EDS.read_text()
    for index in indices:
        text = re.sub(rf"(?ms)^\[{index:X}(sub\d+)?\]$.*?(?=^\[|\Z)", "", text)
        text = re.sub(rf"(?m)^\d+=0x{index:X}\n", "", text)
    path = folder / f"without-{'-'.join(f'{index:X}' for index in indices)}.eds"
    path.write_text(text)
    return path


@contextmanager
def virtual_arm(profile: Profile) -> Iterator[ForkedArm]:
    """The profile's arm as a process of its own, ready on the bus."""
    arm = ForkedArm(profile.path)
    try:
        assert arm.stdout.readline() == "ready\n"
        yield arm
    finally:
        arm.end()


class Driver:
    """A controller that swings every joint, and the loop around a backend."""

    def __init__(self, arm: CanopenBackend, amplitude: float = 0.3, frequency: float = 1.0) -> None:
        self.arm = arm
        self._last: tuple[float, Any] | None = None
        self._amplitude, self._omega = amplitude, 2 * np.pi * frequency
        self._due = time.monotonic()
        self.reach = 0.0
        """The furthest from zero that any joint has been, rad."""

    def torque(self, feedback: Feedback, moving: bool = True) -> Any:
        now, q = feedback.time, feedback.q.copy()
        dq = np.zeros_like(q)
        if self._last is not None and now > self._last[0]:
            dq = (q - self._last[1]) / (now - self._last[0])
        self._last = (now, q)
        if not moving:
            return np.clip(-200 * q - 20 * dq, -90, 90)
        target = self._amplitude * np.sin(self._omega * now)
        speed = self._amplitude * self._omega * np.cos(self._omega * now)
        return np.clip(200 * (target - q) + 20 * (speed - dq) + 20 * np.sin(q), -90, 90)

    def hold(self, feedback: Feedback) -> Any:
        return self.torque(feedback, moving=False)

    def step(self) -> Feedback:
        """One cycle, paced where time is real."""
        if self.arm.realtime:
            left = self._due - time.monotonic()
            if left > 0:
                time.sleep(left)
            self._due = max(self._due + self.arm.period, time.monotonic() - self.arm.period)
        feedback = self.arm.read()
        self.arm.write(self.torque(feedback))
        self.reach = max(self.reach, float(np.abs(feedback.q).max()))
        return feedback

    def run(self, seconds: float) -> Feedback:
        for _ in range(round(seconds / self.arm.period)):
            feedback = self.step()
        return feedback

    def run_on(self, seconds: float) -> None:
        """The same, whatever else is told meanwhile."""
        for _ in range(round(seconds / self.arm.period)):
            with suppress(BackendFault):
                self.step()

    def until(self, condition: Callable[[Feedback], bool], seconds: float = 5.0) -> Feedback:
        """Cycles until the condition holds."""
        for _ in range(round(seconds / self.arm.period)):
            if condition(feedback := self.step()):
                return feedback
        raise AssertionError("it never came to that")


@contextmanager
def promptly() -> Iterator[None]:
    """As the control process does: before all others, where that is allowed."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    with suppress(PermissionError):
        policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
        os.sched_setscheduler(0, policy, os.sched_param(20))
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)


@contextmanager
def running(profile: Profile) -> Iterator[tuple[CanopenBackend, Driver, Meddler]]:
    """Backend open and enabled, the arm swinging, somebody else on the bus."""
    with VirtualBus(profile.can.channel) as bus:
        arm = CanopenBackend(profile)
        arm.open()
        try:
            with promptly():
                driver = Driver(arm)
                by_hand.enable(arm, driver.hold)
                driver.run(0.3)
                yield arm, driver, Meddler(profile, bus)
        finally:
            arm.close()


@contextmanager
def second_master(profile: Profile, axis: int) -> Iterator[RemoteNode]:
    """Another client of the bus, by canopen alone."""
    assert profile.drives is not None
    network = Network()
    network.NOTIFIER_CYCLE = 0.05
    network.connect(interface=profile.can.interface, channel=profile.can.channel)
    try:
        node = network.add_node(profile.drives[axis].node, str(OWN_EDS))
        node.sdo.RESPONSE_TIMEOUT = 2.0
        yield node
    finally:
        network.disconnect()


class Meddler:
    """Another client of the bus, there before anything moves; what it sends it sends at once."""

    def __init__(self, profile: Profile, bus: VirtualBus) -> None:
        self.profile, self.bus = profile, bus

    def sdo(self, axis: int, head: str, value: int, signed: bool = False) -> None:
        """An expedited download, fired and forgotten; ``head`` in hex."""
        assert self.profile.drives is not None
        data = bytes.fromhex(head) + value.to_bytes(4, "little", signed=signed)
        self.bus.send_packet(frame(0x600 + self.profile.drives[axis].node, data))

    def inject(self, axis: int, kind: Injection, argument: int = 0) -> None:
        """Make a fault happen in one virtual drive."""
        self.sdo(axis, "23 00 2F 02", argument, signed=True)
        self.sdo(axis, "2F 00 2F 01", int(kind))


def inject_by_canopen(profile: Profile, axis: int, kind: Injection, argument: int = 0) -> None:
    """The same on any interface of python-can, for where nothing moves too fast for it."""
    with second_master(profile, axis) as node:
        node.sdo[0x2F00][2].raw = argument
        node.sdo[0x2F00][1].raw = int(kind)
