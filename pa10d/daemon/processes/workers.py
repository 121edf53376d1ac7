"""A few low-priority processes that compute; cancelling a task ends its process."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import socket
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pa10d.common.errors import NoRoom, Taken, Unsound, UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.shortage import starting
from pa10d.daemon.processes.budget import Budget
from pa10d.daemon.processes.child import ENVIRONMENT
from pa10d.daemon.processes.crowded import Crowded

NICENESS = 10  # of what computes for long
LARGEST_ANSWER = 8 << 20  # bytes: what is read in one go, while nothing else is done
WAITING = 32  # tasks that wait for a process
TOLD_AS_WELL = 1.0  # s: who tells all our processes to end tells the daemon, which ends the task
FRESH_AFTER = 100  # tasks after which a process gives its memory back by ending

Progress = Callable[[float, str], None]


class TaskFailed(Exception):
    """The task threw what no user could have mended, or its process ended."""


class Ended(TaskFailed):
    """The process was killed, by whomever: nothing is wrong with the task."""


class NeverBegun(Ended):
    """The process ended before it took the task."""


@dataclass(frozen=True)
class TaskEnd:
    """How a task ended. error: why it failed, expected: by a fault of the request; findings, taken,
    no_room: which kind of fault; spent: the process has no memory left for another task."""

    result: Any = None
    error: str | None = None
    expected: bool = False
    findings: list[JsonObject] | None = None
    taken: bool = False
    no_room: bool = False
    spent: bool = False

    def outcome(self) -> Any:
        """The result, as JSON; or what the task failed by is raised here."""
        if self.error is None:
            return self.result
        if self.findings is not None:
            raise Unsound(self.error, self.findings)
        if self.no_room:
            raise NoRoom(self.error)
        raise (Taken if self.taken else UserError if self.expected else TaskFailed)(self.error)


class Workers:
    """``run`` a service function in a process of its own; idle processes are kept for the next."""

    def __init__(self, budget: Budget, most: int | None = None, niceness: int = NICENESS) -> None:
        self._budget, self._niceness = budget, niceness
        self._most = asyncio.Semaphore(most or max(2, os.cpu_count() or 1))
        self._idle: list[Worker] = []
        self._waiting = 0
        self._closed = False

    async def run(self, call: str, progress: Progress, **arguments: Any) -> Any:
        """The function's result; UserError where the request was at fault or took too much.

        Crowded where too many wait already.
        """
        if self._waiting >= WAITING:
            raise Crowded(f"{self._waiting} tasks wait for a process; try again")
        self._waiting += 1
        try:
            await self._most.acquire()
        finally:
            self._waiting -= 1
        try:
            answer = await self._by_whoever_lives(call, arguments, progress)
        finally:
            self._most.release()
        return answer.outcome()

    async def _by_whoever_lives(
        self, call: str, arguments: JsonObject, progress: Progress
    ) -> TaskEnd:
        """An idle process may have ended without anybody having noticed yet: it is not missed."""
        while (worker := self._take_idle()) is not None:
            with contextlib.suppress(NeverBegun):
                return await self._by(worker, call, arguments, progress)
        return await self._by(await self._fresh(), call, arguments, progress)

    async def _by(
        self, worker: Worker, call: str, arguments: JsonObject, progress: Progress
    ) -> TaskEnd:
        try:
            async with asyncio.timeout(self._budget.seconds) as limit:
                answer = await worker.carry_out(call, arguments, progress)
        except BaseException as error:
            worker.kill()
            if isinstance(error, TimeoutError) and limit.expired():
                raise UserError(self._budget.time_is_over()) from error
            raise
        self._keep(worker, answer)
        return answer

    async def _fresh(self) -> Worker:
        return await Worker.start(self._niceness, self._budget.memory)

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

    def _keep(self, worker: Worker, answer: TaskEnd) -> None:
        worker.done += 1
        if self._closed or answer.spent or worker.done >= FRESH_AFTER:
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
        self.done = 0  # tasks

    @staticmethod
    async def start(niceness: int, memory: int) -> Worker:
        """A fresh one that may take ``memory`` bytes."""
        with starting():
            ours, theirs = socket.socketpair()
        with starting(ours, theirs):
            process = await asyncio.create_subprocess_exec(
                sys.executable, "-m", "pa10d.daemon.processes.worker",
                "--pipe", str(theirs.fileno()), "--nice", str(niceness), "--memory", str(memory),
                pass_fds=(theirs.fileno(),),
                stdin=asyncio.subprocess.DEVNULL,
                env={**os.environ, **ENVIRONMENT},
            )  # fmt: skip
        theirs.close()
        reader, writer = await asyncio.open_connection(sock=ours, limit=LARGEST_ANSWER)
        return Worker(process, reader, writer)

    async def carry_out(self, call: str, arguments: JsonObject, progress: Progress) -> TaskEnd:
        """Send the task, pass its progress on, return the last line."""
        task, begun = json.dumps({"call": call, "arguments": arguments}), False
        try:
            self._writer.write(task.encode() + b"\n")
            await self._writer.drain()
            while line := await self._reader.readline():
                message: JsonObject = json.loads(line)
                if "begun" in message:
                    begun = True
                elif "progress" in message:
                    progress(message["progress"], message["message"])
                else:
                    return TaskEnd(**message)
        except ConnectionError:
            pass
        except ValueError as error:
            raise TaskFailed(f"the answer is longer than {LARGEST_ANSWER} bytes") from error
        code = await self.process.wait()
        if code == -signal.SIGTERM:
            await asyncio.sleep(TOLD_AS_WELL)
        how = f"by signal {-code}" if code < 0 else f"with status {code}"
        raise (Ended if begun else NeverBegun)(f"the worker process was ended {how}")

    def kill(self) -> None:
        """End it at once."""
        self._writer.close()
        with contextlib.suppress(ProcessLookupError):
            self.process.kill()
