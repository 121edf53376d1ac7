"""A process of ours with a pipe to it: started, watched, ended."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import sys
from collections.abc import Callable, Sequence
from signal import SIGABRT, SIGKILL

from pa10d.common.shortage import starting
from pa10d.daemon.processes.link import Link, LinkClosed, Message

LEAVES_TRACE = 2.0  # s
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONUNBUFFERED": "1"}


class Child:
    """``python -m module arguments --pipe FD``; ready once it has said so."""

    def __init__(
        self, name: str, process: asyncio.subprocess.Process, link: Link, ready: asyncio.Event
    ) -> None:
        self.name, self.process, self.link = name, process, link
        self._ready = ready
        self.welcome: Message = {}
        self.last_words = ""  # why it ended, as far as it could tell, or whoever ended it

    @property
    def pid(self) -> int:
        """Process id."""
        return self.process.pid

    @staticmethod
    async def start(
        name: str,
        module: str,
        arguments: Sequence[str],
        on_event: Callable[[Message], None],
        inherit: Sequence[int] = (),
    ) -> Child:
        """Start it; the descriptors in ``inherit`` stay open in it as well. Short where the machine
        gives no more of what that takes."""
        with starting():
            ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        for end in (ours, theirs):
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 20)
        ready = asyncio.Event()
        child: Child

        def heard(message: Message) -> None:
            if message["event"] == "ready":
                child.welcome = message
                ready.set()
            elif message["event"] == "ends":
                child.last_words = str(message["why"])
            else:
                on_event(message)

        with starting(ours, theirs):
            process = await asyncio.create_subprocess_exec(
                sys.executable, "-m", module, *arguments, "--pipe", str(theirs.fileno()),
                pass_fds=(theirs.fileno(), *inherit),
                stdin=asyncio.subprocess.DEVNULL,
                env={**os.environ, **ENVIRONMENT},
            )  # fmt: skip
        theirs.close()
        child = Child(name, process, Link(ours, heard), ready)
        return child

    async def ready(self, timeout: float) -> bool:
        """Whether it said that it is ready, in time and before it ended; nobody else ends it if
        this is cancelled."""
        ended = asyncio.ensure_future(self.process.wait())
        said = asyncio.ensure_future(self._ready.wait())
        try:
            await asyncio.wait((ended, said), timeout=timeout, return_when=asyncio.FIRST_COMPLETED)
        except asyncio.CancelledError:
            await self.end(0.0, polite=False)
            raise
        finally:
            for task in (ended, said):
                task.cancel()
        return self._ready.is_set()

    async def end(self, timeout: float, polite: bool = True) -> None:
        """Tell it to end, or close the pipe, which says the same; kill it once time is over."""
        if polite:
            with contextlib.suppress(LinkClosed):
                self.link.tell("end")
        else:
            self.link.close()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self.process.wait(), timeout)
        self.link.close()
        if self.process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                self.process.kill()
            await self.process.wait()

    async def break_off(self, why: str) -> None:
        """End one that hangs; it may leave a trace of where, if it can."""
        self.last_words = why
        for signal in (SIGABRT, SIGKILL):
            with contextlib.suppress(ProcessLookupError):
                self.process.send_signal(signal)
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self.process.wait(), LEAVES_TRACE)
                return

    def how_it_ended(self) -> str:
        """For a person."""
        code = self.process.returncode
        if code is None:
            return "is running"
        how = f"was ended by signal {-code}" if code < 0 else f"ended with status {code}"
        return f"{how}: {self.last_words}" if self.last_words else how
