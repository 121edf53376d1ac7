"""Control loop, CANopen backend and virtual drives in one thread, on a clock that only we move.

Who runs when is a schedule and not the machine's mood: ``stall`` keeps control or the arm from
running for a while, ``kill`` for ever. All else is the product's own code, with ``time`` and
``select`` of the modules that look at the clock replaced by this world's.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import os
import socket
import sys
import threading
import time as real_time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import yaml
from small_arm import CHOSEN, joints_of_the_arm

from backends.canopen_cia402.backend import CanopenBackend
from backends.virtual.drives.node import OPERATIONAL
from backends.virtual.machine import VirtualArm
from pa10d.control.build import build_arm, servo_factory
from pa10d.control.commands import Commands
from pa10d.control.faults import Fault
from pa10d.control.loop import Loop
from pa10d.control.mailbox import LARGEST
from pa10d.control.ring import Ring
from pa10d.control.rows import sealed
from pa10d.dynamics import Robot, robot_from_profile
from pa10d.experiments.motion import rows_of, whole_motion
from pa10d.profile import Profile, load_profile
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.poses import Surroundings

Story = Iterator[Callable[[], bool]]
LOOKING_AT_THE_CLOCK = ("backends.virtual", "backends.canopen_cia402", "pa10d.control")
ALIVE_EVERY = 0.5  # s between the daemon's signs of life
PATIENCE = 60.0  # s of this world's time that anything may take
COMPUTING = 2e-4  # s that drives take to answer


class Killed(BaseException):
    """Control is gone, at whatever it was."""


class World:
    """``run`` tells a story; ``farthest`` and ``fastest`` say what the arm did meanwhile."""

    def __init__(self, profile: Profile, folder: Path, patch: Callable[..., None]) -> None:
        self.now = 1000.0
        self.profile, self.folder = profile, folder
        self._lock = threading.Condition(threading.RLock())
        self._to_arm: list[bytes] = []
        self._to_control: list[bytes] = []
        self._asleep = {"control": 0.0, "arm": 0.0}  # until when each stands still
        self.at_once = sys.maxsize  # packets that the arm takes in before others run again
        self._story: Story = iter(())
        self._condition: Callable[[], bool] = lambda: True
        self._since, self._said_alive = 0.0, 0.0
        self._failure: BaseException | None = None
        self._threads = threading.active_count()
        self.told: list[dict] = []  # what control told the daemon
        self.faults: list[Fault] = []  # that were latched, whoever was told
        self._take_the_clock(patch)
        self.robot: Robot = robot_from_profile(profile)
        self.drives = VirtualArm(profile, _End(self, self._to_arm, self._to_control, arm=True))
        self._at_once(self.drives)
        self.ring = Ring.create(self.robot.n, 4096, self.drives.period)
        self._start_control()
        self._numbers = itertools.count(1)
        n = self.robot.n
        self.lowest, self.highest, self.fastest = np.full(n, np.inf), np.full(n, -np.inf), 0.0

    def _start_control(self) -> None:
        profile, ring = self.profile, self.ring
        backend = CanopenBackend(
            profile, lambda: _End(self, self._to_control, self._to_arm, arm=False)
        )
        self.arm = build_arm(profile, self.robot, backend, ring)
        make_servo = servo_factory(profile, self.robot, backend.period)
        self._pipe, self._theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._pipe.setblocking(False)
        commands = Commands(self.arm, self.robot, make_servo)
        self.loop = Loop(self.arm, ring, commands, self._theirs)

    # --- what a story is made of ---

    def run(self, story: Story) -> None:
        """Cycles until the story is over, then the daemon leaves and control ends by itself."""
        self._story, self._condition, self._since = story, lambda: True, self.now
        with contextlib.suppress(Killed):
            self.loop.run()
        if self._failure is not None:
            raise self._failure

    def say(self, do: str, **more: object) -> None:
        """As the daemon does."""
        message = {"id": next(self._numbers), "do": do, **more}
        self._pipe.send(json.dumps(message).encode())

    def follow(self, memory: int, **more: object) -> None:
        """Rows of sealed memory, as the daemon hands them over."""
        message = {"id": next(self._numbers), "do": "run", **more}
        socket.send_fds(self._pipe, [json.dumps(message).encode()], [memory])
        os.close(memory)

    def heard(self, do_id: int | None = None) -> list[dict]:
        """Everything that control answered so far."""
        while True:
            try:
                packet = self._pipe.recv(LARGEST)
            except (BlockingIOError, OSError):
                return self.told
            if not packet:
                return self.told
            self.told.append(json.loads(packet))

    def leave(self) -> None:
        """The daemon dies."""
        self._pipe.close()

    def fall_silent(self) -> None:
        """The daemon hangs."""
        self._said_alive = math.inf

    def close(self) -> None:
        """What goes with the processes that were killed."""
        self._pipe.close()
        self._theirs.close()
        self.arm.backend._drop_port()

    def stall(self, who: str, seconds: float) -> None:
        """Control or arm stands still from now on."""
        self._asleep[who] = self.now + seconds

    def kill(self, who: str) -> None:
        """… and never goes on."""
        self._asleep[who] = math.inf

    def start_control_again(self) -> None:
        """After it was killed, on the same drives; ``run`` tells what follows."""
        self.close()
        self._to_control.clear()
        self._asleep["control"] = 0.0
        self._start_control()

    def state(self) -> str:
        return self.arm.state.label

    def is_in(self, *states: str) -> Callable[[], bool]:
        return lambda: self.state() in states

    def passes(self, seconds: float) -> Callable[[], bool]:
        until = self.now + seconds
        return lambda: self.now >= until

    def swing(self, **parameters: float) -> None:
        """Have control follow a motion of every joint to both sides of zero."""
        parameters = {"period": 4.0, "cycles": 8, **parameters}
        request = read_request({"kind": "tracking", "parameters": parameters})
        plan = request.build(Surroundings.of(self.robot))
        rate = self.profile.control.rate
        whole = whole_motion(plan, self.arm.path.reference.q.copy(), self.robot, rate)
        path = self.folder / f"rows-{next(self._numbers)}.npy"
        np.save(path, rows_of(whole, None, None))
        self.follow(sealed(path), number=1, first=whole.first, last=whole.last)

    def moving(self) -> Story:
        """From nothing to an arm that swings."""
        self.say("connect")
        yield self.is_in("inactive")
        self.say("enable")
        yield self.is_in("holding")
        self.swing()
        yield lambda: bool(np.abs(self.drives.mechanics.velocity).max() > 0.3)

    # --- what is looked at afterwards ---

    def at_rest(self) -> bool:
        """Unpowered, every brake closed, and nothing moves."""
        off = not any(drive.machine.powered for drive in self.drives.drives)
        braked = all(drive.brake_closed for drive in self.drives.drives)
        return off and braked and float(np.abs(self.drives.mechanics.velocity).max()) < 1e-2

    def rests_within(self, seconds: float) -> float:
        """Time without control, s until rest."""
        began = self.now
        while not self.at_rest():
            assert self.now - began < seconds, self.how_it_is()
            self.advance(self.now + self.drives.period)
        return self.now - began

    def how_it_is(self) -> str:
        states = [str(drive.machine.state) for drive in self.drives.drives]
        return f"at {self.now:.3f} s: {self.state()}, fault {self.arm.fault}, drives {states}"

    # --- the clock, as the product's modules see it ---

    def monotonic(self) -> float:
        return self.now

    perf_counter = monotonic

    def thread_time(self) -> float:
        return 0.0

    def time(self) -> float:
        return real_time.time()

    def sleep(self, seconds: float) -> None:
        if threading.current_thread() is not threading.main_thread():
            real_time.sleep(min(seconds, 0.001))
            return
        self._control_waits(self.now + max(seconds, 0.0))

    def select(self, readers: list, writers: list, errors: list, timeout: float) -> tuple:
        """Control waits for a word of the daemon."""
        until = self.now + timeout
        while self.now < until:
            self._control_waits(min(until, self.now + self.drives.period))
            if _readable(self._theirs):
                return readers, [], []
        return [], [], []

    def _control_waits(self, until: float) -> None:
        self.advance(until)
        if self.arm.fault is not None and self.arm.fault not in self.faults:
            self.faults.append(self.arm.fault)
        self._tell_on()
        if self._asleep["control"] > self.now:
            if math.isinf(self._asleep["control"]):
                raise Killed
            self.advance(self._asleep["control"])

    def advance(self, until: float) -> None:
        """Time passes for the arm; of an arm in simulated time only while somebody waits for it."""
        with self._lock:
            while self.drives.realtime:
                due = max(
                    self.now, self._asleep["arm"], self.drives._time + 1.5 * self.drives.period
                )
                if due > until:
                    break
                self.now = due
                self._arm_runs()
                self.drives.tick()
                self._look()
            self.now = max(self.now, until)
            if self._asleep["arm"] <= self.now:
                self._arm_runs()

    def wait_for_frames(self, timeout: float) -> None:
        """Control waits for an answer."""
        until = self.now + timeout
        while not self._to_control and self.now < until:
            self.advance(min(until, self.now + COMPUTING))

    # --- inside ---

    def _arm_runs(self) -> None:
        for _ in range(min(len(self._to_arm), self.at_once)):
            packet = self._to_arm.pop(0)
            self.drives.handle(packet)
            self._look()

    def _look(self) -> None:
        q = self.drives.mechanics.q
        np.minimum(self.lowest, q, out=self.lowest)
        np.maximum(self.highest, q, out=self.highest)
        self.fastest = max(self.fastest, float(np.abs(self.drives.mechanics.velocity).max()))

    @property
    def farthest(self) -> float:
        """rad from zero that any joint has been."""
        return float(np.maximum(-self.lowest, self.highest).max())

    def _tell_on(self) -> None:
        if self._pipe.fileno() < 0:
            return
        if self.now - self._said_alive > ALIVE_EVERY:
            self._said_alive = self.now
            self._pipe.send(b'{"do": "alive"}')
        self.heard()
        try:
            while self._condition():
                self._condition, self._since = next(self._story), self.now
            if threading.active_count() > self._threads:  # drives are being opened: in real time
                real_time.sleep(1e-3)
                self._since = self.now
            assert self.now - self._since < PATIENCE, f"waited in vain; {self.how_it_is()}"
        except StopIteration:
            self._condition = lambda: False
            self._since = math.inf
            self.leave()
        except BaseException as failure:
            self._failure, self._condition = failure, lambda: False
            self._since = math.inf
            self.leave()

    def _take_the_clock(self, patch: Callable[..., None]) -> None:
        for name, module in list(sys.modules.items()):
            if name.startswith(LOOKING_AT_THE_CLOCK):
                if getattr(module, "time", None) is real_time:
                    patch(module, "time", self)
                if getattr(module, "select", None) is sys.modules["select"]:
                    patch(module, "select", self)

    def _at_once(self, drives: VirtualArm) -> None:
        while not drives.booted:
            self.now += drives.period
            drives.tick()
        self._to_control.clear()


class _End:
    """One end of the wire."""

    deserted = False

    def __init__(self, world: World, inbox: list[bytes], outbox: list[bytes], arm: bool) -> None:
        self._world, self._inbox, self._outbox, self._arm = world, inbox, outbox, arm

    def send(self, packet: bytes) -> None:
        world = self._world
        with world._lock:
            self._outbox.append(packet)
            if not self._arm and world._asleep["arm"] <= world.now:
                world._arm_runs()
            world._lock.notify_all()

    def receive(self, timeout: float) -> bytes:
        world = self._world
        if threading.current_thread() is threading.main_thread():
            if not self._arm and not world.drives.realtime:
                world._tell_on()  # no cycle waits for its time
            if not self._inbox and timeout > 0:
                world.wait_for_frames(timeout)
        else:  # the thread that listens while drives are configured
            with world._lock:
                if not self._inbox:
                    world._lock.wait(0.002)
                if not self._inbox and any(
                    d.node.state != OPERATIONAL for d in world.drives.drives
                ):
                    world.advance(world.now + world.drives.period)
        with world._lock:
            packet = b"".join(self._inbox)
            self._inbox.clear()
        return packet

    def close(self) -> None:
        self._inbox.clear()


def _readable(connection: socket.socket) -> bool:
    import select

    return bool(select.select([connection], [], [], 0)[0])


def profile_in(folder: Path, chosen: Sequence[int] = CHOSEN, **changes: object) -> Profile:
    """Joints of the simulated PA10 in real time, which here is the world's."""
    document = joints_of_the_arm(chosen)
    document["can"]["channel"] = f"s{os.getpid()}"
    for key, value in changes.items():
        document[key] = {**document.get(key, {}), **value} if isinstance(value, dict) else value
    path = folder / "arm.yaml"
    path.write_text(yaml.safe_dump(document))
    return load_profile(path)


__all__ = ["World", "profile_in"]
