"""What is known of a kind of device without opening one: its words, its wire, what it needs.

The daemon, the page and the pre-checks speak of drives while another process holds them. A backend
whose device says more than position and torque exports a ``DEVICE`` beside its factory; one without
is taken as ``PLAIN``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from pa10d.profile import Profile


class Wire(Protocol):
    """What a bus has to carry, judged against what it can."""

    @property
    def fits(self) -> bool: ...

    def sentence(self) -> str: ...


@dataclass(frozen=True)
class Device:
    """Of a status word: ``state`` in words (None: no such word) and ``remarks`` beside it."""

    state: Callable[[int], str | None] = lambda _: None
    remarks: Callable[[int], list[str]] = lambda _: []
    wire: Callable[[Profile], Wire | None] = lambda _: None
    lacking: Callable[[Profile], str | None] = lambda _: None  # why a profile cannot be opened


PLAIN = Device()
