"""A few low-priority processes that compute; cancelling a task ends its process."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import socket
import sys
from collections.abc import Callable
from typing import Any

from pa10d.daemon.child import ENVIRONMENT
from pa10d.errors import UserError

NICENESS = 10  # of what computes for long
LARGEST_ANSWER = 1 << 28  # bytes

Progress = Callable[[float, str], None]


class TaskFailed(Exception):
    """The task threw what no user could have mended, or its process ended."""


class Workers:
    """``run`` a service function in a process of its own; idle processes are kept for the next."""

    def __init__(self, most: int | None = None, niceness: int = NICENESS) -> None:
        self._niceness = niceness
        self._most = asyncio.Semaphore(most or max(2, os.cpu_count() or 1))
        self._idle: list[Worker] = []
        self._closed = False

    async def warm_up(self) -> None:
        """Have one ready before it is needed."""
        self._idle.append(await Worker.start(self._niceness))

    async def run(self, call: str, progress: Progress, **arguments: Any) -> Any:
        """The function's result; UserError where the request was at fault."""
        async with self._most:
            worker = self._take_idle() or await Worker.start(self._niceness)
            try:
                answer = await worker.carry_out(call, arguments, progress)
            except BaseException:
                worker.kill()
                raise
            self._keep(worker)
        if "error" in answer:
            raise (UserError if answer["expected"] else TaskFailed)(answer["error"])
        return answer["result"]

    def pids(self) -> list[int]:
        """Of the idle ones."""
        return [worker.process.pid for worker in self._idle]

    def close(self) -> None:
        """End them all."""
        self._closed = True
        for worker in self._idle:
            worker.kill()
        self._idle.clear()

    def _take_idle(self) -> Worker | None:
        """One that is still alive."""
        while self._idle:
            worker = self._idle.pop()
            if worker.process.returncode is None:
                return worker
            worker.kill()
        return None

    def _keep(self, worker: Worker) -> None:
        if self._closed:
            worker.kill()
        else:
            self._idle.append(worker)


class Worker:
    """One process and its pipe."""

    def __init__(
        self,
        process: asyncio.subprocess.Process,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
    ) -> None:
        self.process, self._reader, self._writer = process, reader, writer

    @staticmethod
    async def start(niceness: int) -> Worker:
        """A fresh one."""
        ours, theirs = socket.socketpair()
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "pa10d.daemon.worker", "--pipe", str(theirs.fileno()),
            "--nice", str(niceness),
            pass_fds=(theirs.fileno(),),
            stdin=asyncio.subprocess.DEVNULL,
            env={**os.environ, **ENVIRONMENT},
        )  # fmt: skip
        theirs.close()
        reader, writer = await asyncio.open_connection(sock=ours, limit=LARGEST_ANSWER)
        return Worker(process, reader, writer)

    async def carry_out(
        self, call: str, arguments: dict[str, Any], progress: Progress
    ) -> dict[str, Any]:
        """Send the task, pass its progress on, return the last line."""
        task = json.dumps({"call": call, "arguments": arguments})
        try:
            self._writer.write(task.encode() + b"\n")
            await self._writer.drain()
            while line := await self._reader.readline():
                message: dict[str, Any] = json.loads(line)
                if "progress" not in message:
                    return message
                progress(message["progress"], message["message"])
        except ConnectionError:
            pass
        code = await self.process.wait()
        how = f"by signal {-code}" if code < 0 else f"with status {code}"
        raise TaskFailed(f"the worker process was ended {how}")

    def kill(self) -> None:
        """End it at once."""
        self._writer.close()
        with contextlib.suppress(ProcessLookupError):
            self.process.kill()
