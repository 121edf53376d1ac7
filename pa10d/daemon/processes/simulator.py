"""The virtual arm as a process of its own, started by the daemon where nobody else has."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import logging
import os
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator

from backends.arm_lock import Held, arm_leaves, arm_lock, is_simulated, refuse_arm_of_others
from pa10d.common.errors import UserError
from pa10d.common.shortage import Short, starting
from pa10d.common.terminal import leave_terminal_to_daemon
from pa10d.common.unhurried_log import log_unhurried
from pa10d.daemon.offline import SLOW
from pa10d.daemon.processes.child import ENVIRONMENT
from pa10d.profile import Profile

START_TIME = 120.0  # s for which all else waits; the plant may have to be compiled for longer
END_TIME = 2.0  # s; nothing is lost where it is killed
LOOKS = 0.1  # s between two looks whether an arm that leaves is gone
READY, REFUSED = "ready", "refused: "  # what it says, in a line; a plant may print others
SILENT = "the virtual arm did not start; its messages are in the log"
PRIORITY = 70  # below the control process: drives answer in time, but do not hold the loop up

log = logging.getLogger("pa10d.simulator")


def wants_simulator(profile: Profile) -> bool:
    """Whether the profile's bus carries a virtual arm."""
    return profile.simulation is not None and profile.can.interface in ("virtualbus", "virtual")


def refuse_no_arm(profile: Profile) -> None:
    """UserError where the virtual arm of this profile cannot be made, in the line that says why;
    nobody would answer on its bus, as if a cable were off."""
    from backends.virtual.load_plant import made_plant

    if profile.drives and wants_simulator(profile) and not is_simulated(profile):
        made_plant(profile, len(profile.drives))


class Simulator:
    """It does not come back by itself, a dead arm is a fault to be seen; ``start`` starts anew."""

    def __init__(self, profile: Profile) -> None:
        self._profile = profile
        self.process: asyncio.subprocess.Process | None = None
        self._alive: int | None = None  # held open as long as it shall live
        self._hearing: asyncio.Task[None] | None = None  # for its word
        self.refusal: str | None = None  # why there is no arm to be used

    @property
    def dead(self) -> str | None:
        """How the arm that was started here ended, None while it lives."""
        code = None if self.process is None else self.process.returncode
        if code is None:
            return None
        return f"was ended by signal {-code}" if code < 0 else f"ended with status {code}"

    async def start(self) -> None:
        """Until it is on the bus. Where one is there already, that one is used; one whose daemon
        has gone is waited for."""
        while arm_leaves(self._profile):
            await asyncio.sleep(LOOKS)
        self.refusal = None
        try:
            refuse_arm_of_others(self._profile, os.getpid())
        except UserError as error:
            self.refusal = str(error)
            return
        if is_simulated(self._profile):
            log.info("the virtual arm that is on '%s' already is used", self._profile.can.channel)
            return
        try:
            self.process, writing = await _begun()
        except Short as error:
            self.refusal = str(error)
            log.error("the virtual arm cannot be started: %s", error)
            return
        self._let_go()
        self._alive = writing
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(self._profile.model_dump_json().encode())
        self.process.stdin.close()
        self.refusal = SLOW
        self._hearing = asyncio.create_task(self._hear(self.process, self.process.stdout))
        await asyncio.wait([self._hearing], timeout=START_TIME)

    async def _hear(self, process: asyncio.subprocess.Process, said: asyncio.StreamReader) -> None:
        """Its word, whenever it comes; not of one whose place another has taken."""
        refusal = await _heard(said)
        if process is self.process:
            self.refusal = refusal

    def refuse_unless_own(self) -> None:
        """UserError where the arm on the bus is somebody else's, and cannot become another."""
        if self.process is None:
            raise UserError(
                "the virtual arm runs in a process of its own, started by somebody else; expected "
                "the one that the daemon starts"
            )

    async def become(self, profile: Profile) -> None:
        """Another arm on the same bus: the one that was started here ends first."""
        self.refuse_unless_own()
        assert self.process is not None
        process, self.process = self.process, None  # its end is no fault
        await self._end(process)
        self._profile = profile
        await self.start()

    async def close(self) -> None:
        """End it."""
        if self.process is not None:
            await self._end(self.process)

    async def _end(self, process: asyncio.subprocess.Process) -> None:
        self._let_go()
        with contextlib.suppress(ProcessLookupError):
            process.terminate()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(process.wait(), END_TIME)
        if process.returncode is None:
            process.kill()
            await process.wait()

    def _let_go(self) -> None:
        """The one that there was may end."""
        if self._alive is not None:
            os.close(self._alive)
            self._alive = None


async def _begun() -> tuple[asyncio.subprocess.Process, int]:
    """The process, and what is to be held open as long as it shall live."""
    with starting():
        reading, writing = os.pipe()
    with starting(reading, writing):
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "pa10d.daemon.processes.simulator", "--alive", str(reading),
            "--daemon", str(os.getpid()),
            pass_fds=(reading,),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            env={**os.environ, **ENVIRONMENT},
        )  # fmt: skip
    os.close(reading)
    return process, writing


async def _heard(said: asyncio.StreamReader) -> str | None:
    """Why there is no arm, None once there is."""
    while line := await said.readline():
        if (refusal := _refusal(line.decode(errors="replace"))) != SILENT:
            return refusal
    return SILENT


def _refusal(line: str) -> str | None:
    """By a line that a simulator said: None where it is ready."""
    if line.strip() == READY:
        return None
    return line.removeprefix(REFUSED).strip() if line.startswith(REFUSED) else SILENT


def serve_arm(
    profile: Profile, ready: Callable[[], None], stopped: Callable[[], bool] = lambda: False
) -> None:
    """The virtual arm in this process, until told to end; in real time with real-time priority."""
    from backends.virtual.arm import serve
    from pa10d.control.realtime import prepare

    def on_the_bus() -> None:
        if profile.simulation is not None and profile.simulation.clock == "real":
            prepare(PRIORITY)
        ready()

    with contextlib.suppress(KeyboardInterrupt):
        serve(profile, ready=on_the_bus, stopped=stopped)


@contextlib.contextmanager
def simulated_bus(profile: Profile) -> Iterator[None]:
    """A virtual arm for the length of the block, where the profile wants one and none is there."""
    while wants_simulator(profile) and arm_leaves(profile):
        time.sleep(LOOKS)
    refuse_arm_of_others(profile)
    if not wants_simulator(profile) or is_simulated(profile):
        yield
        return
    reading, writing = os.pipe()
    process = subprocess.Popen(
        [sys.executable, "-m", "pa10d.daemon.processes.simulator", "--alive", str(reading)],
        pass_fds=(reading,), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env={**os.environ, **ENVIRONMENT},
    )  # fmt: skip
    os.close(reading)
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        process.stdin.write(profile.model_dump_json())
        process.stdin.close()
        said = (found for line in process.stdout if (found := _refusal(line)) != SILENT)
        if (refusal := next(said, SILENT)) is not None:
            raise UserError(refusal)
        yield
    finally:
        os.close(writing)
        process.terminate()
        process.wait()
        process.stdout.close()


LINGER = 5.0  # s for which the arm outlives its daemon: it has to come to rest first


def main() -> None:
    """Profile on stdin; ends when the daemon has been gone for a while, or when told to."""
    parser = argparse.ArgumentParser(prog="pa10d-simulator")
    parser.add_argument("--alive", type=int, required=True, help="closed when the daemon ends")
    parser.add_argument("--daemon", type=int, help="process that it is for alone")
    given = parser.parse_args()
    leave_terminal_to_daemon()
    log_unhurried("%(name)s: %(message)s")
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    profile = Profile.model_validate_json(sys.stdin.read())
    try:
        with arm_lock(profile, given.daemon) as held:
            if held is None:
                refuse_arm_of_others(profile, given.daemon)
                print(READY, flush=True)
            else:
                play(profile, given.alive, held)
    except UserError as error:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)  # it ends by itself, and in one line
        print(REFUSED + " ".join(str(error).split()), flush=True)
        sys.exit(1)


def play(profile: Profile, alive: int, held: Held) -> None:
    """The virtual arm, until its daemon tells it to end or ``alive`` has been closed for a while.
    Told by another while its daemon is there, it stays so long: a signal to a whole group, or a
    service's, is for that one, too, and drives do not go before the arm rests."""
    gone = threading.Event()

    def told(*_: object) -> None:
        if select.select([alive], [], [], 0)[0]:
            raise KeyboardInterrupt
        threading.Thread(target=linger, daemon=True).start()

    def linger() -> None:
        gone.wait(LINGER)
        gone.set()

    def watch() -> None:
        os.read(alive, 1)
        with contextlib.suppress(OSError):  # it has ended by itself meanwhile
            held.leave()
        linger()

    signal.signal(signal.SIGTERM, told)
    threading.Thread(target=watch, daemon=True).start()
    serve_arm(profile, lambda: print(READY, flush=True), gone.is_set)


if __name__ == "__main__":
    main()
