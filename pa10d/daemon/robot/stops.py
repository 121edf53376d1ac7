"""Who asked the arm to stop, and what had begun before: none of that moves the arm any more.

A stop brings the arm to rest. What was only on its way to a motion (planning, checking, between two
motions of a series) has to hear of it, too: whoever pressed STOP does not expect the arm to be
powered a second later. Each work that moves the arm is marked with how many stops there had been
when it was asked for; commands that power or move the arm are refused once there was another.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Coroutine, Iterator
from contextvars import ContextVar
from typing import Any, TypeVar

from pa10d.common.errors import Stopped

MOVES = ("enable", "run")
"""Commands that put torque on the joints, or move them."""

T = TypeVar("T")
_BEGAN: ContextVar[int | None] = ContextVar("stops when it was asked for", default=None)


class Stops:
    """How often somebody has asked for a stop."""

    def __init__(self) -> None:
        self.count = 0
        self._next = asyncio.Event()

    def ask(self) -> None:
        """One more."""
        self.count += 1
        self._next.set()
        self._next = asyncio.Event()

    @contextlib.contextmanager
    def heard_by(self, began: int) -> Iterator[None]:
        """What runs in here, and what it starts, was asked for after ``began`` stops."""
        token = _BEGAN.set(began)
        try:
            yield
        finally:
            _BEGAN.reset(token)

    @contextlib.contextmanager
    def heard_from_now(self) -> Iterator[None]:
        """The same for what is asked for now, unless it is part of something that began before."""
        began = _BEGAN.get()
        with self.heard_by(self.count if began is None else began):
            yield

    def refuse(self) -> None:
        """Stopped where somebody has asked for a stop since this work was asked for."""
        if _BEGAN.get() not in (None, self.count):
            raise Stopped(
                "somebody stopped the arm; what had begun before does not move it any more"
            )

    async def unless(self, work: Coroutine[Any, Any, T]) -> T:
        """Its result; Stopped as soon as somebody asks for a stop, without waiting for it."""
        task, stop = asyncio.ensure_future(work), asyncio.ensure_future(self._next.wait())
        try:
            self.refuse()
            await asyncio.wait([task, stop], return_when=asyncio.FIRST_COMPLETED)
            self.refuse()
            return await task
        finally:
            for one in (task, stop):
                one.cancel()
            await asyncio.wait((task, stop))
