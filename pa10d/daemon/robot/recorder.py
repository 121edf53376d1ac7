"""The recorder as the daemon sees it: kept alive, told of motions before they begin."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from typing import Any

from pa10d.common.shortage import Short
from pa10d.daemon.processes.child import Child
from pa10d.daemon.processes.link import LinkClosed, Message
from pa10d.daemon.robot.refusals import CommandRefused

START_TIME = 180.0  # s for imports and compilation on a slow machine
LAST_WORDS = 1.0  # s to close a run once control has ended
AGAIN_AFTER = 0.5  # s
SHORT_FOR = 5.0  # s until a machine that had too little of something is asked again

log = logging.getLogger("pa10d.robot")


class KeptRecorder:
    """One process after the other. start: begins one; lost: to be called after one has ended;
    back: once the next one is there, with the run that was announced last, which it has repaired
    where it was being written."""

    def __init__(
        self,
        start: Callable[[], Awaitable[Child]],
        lost: Callable[[], None],
        back: Callable[[str], Awaitable[None]],
    ) -> None:
        self._start, self._lost, self._back = start, lost, back
        self._announced: str | None = None
        self.child: Child | None = None
        self.keeps = True  # one that ends is followed by another

    async def keep(self) -> None:
        """Start it again whenever it ends."""
        while True:
            try:
                child = await self._start()
            except Short as error:
                log.error("the recorder cannot be started: %s", error)
                await asyncio.sleep(SHORT_FOR)
                continue
            if await child.ready(START_TIME):
                self.child = child
                if self._announced is not None:
                    await self._back(self._announced)
                await child.process.wait()
            await child.end(1.0, polite=False)
            self.child = None
            self._lost()
            log.warning("recorder %s; it is being started again", child.how_it_ended())
            await asyncio.sleep(AGAIN_AFTER)

    async def end(self) -> None:
        """Close what it writes, and end."""
        if self.child is not None:
            await self.child.end(LAST_WORDS, polite=False)

    async def announce(self, **fields: Any) -> Message:
        """Have it await a motion. One that has just died, noticed or not, is started again, and
        that is waited for: nothing was lost yet."""
        child = await self._living()
        try:
            answer = await _ask(child, "announce", **fields)
        except CommandRefused:
            if not child.link.closed:
                raise
            answer = await _ask(await self._living(), "announce", **fields)
        self._announced = str(answer["run"]["id"])
        return answer

    async def withdraw(self) -> bool:
        """Whether the announced motion had not begun: its run goes away."""
        return bool((await _ask(await self._living(), "withdraw"))["withdrawn"])

    async def _living(self) -> Child:
        until = time.monotonic() + START_TIME
        while self.keeps and time.monotonic() < until:
            if self.child is not None and not self.child.link.closed:
                return self.child
            await asyncio.sleep(0.1)
        raise CommandRefused({"detail": "the recorder does not start; look at the log"})


async def _ask(child: Child, do: str, **fields: Any) -> Message:
    try:
        answer = await child.link.ask(do, **fields)
    except LinkClosed as error:
        raise CommandRefused({"detail": f"recorder: {error}"}) from error
    if not answer["ok"]:
        raise CommandRefused(answer)
    return answer
