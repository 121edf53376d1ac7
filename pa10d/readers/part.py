"""Which part of a file is meant, where it holds several recordings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pa10d.common.errors import UserError


@dataclass(frozen=True)
class Part:
    """topic: of a bag, several with commas between them, or a bus of a CAN log; episode: of a data
    set, its own number. None: the reader takes one and says so."""

    topic: str | None = None
    episode: int | None = None

    def only(self, path: Path, *, topic: bool = False, episode: bool = False) -> None:
        """UserError where something is asked for that this kind of file does not have."""
        if self.topic is not None and not topic:
            raise UserError(f"{path}: no topics; --topic {self.topic} expects a bag, or a CAN log")
        if self.episode is not None and not episode:
            raise UserError(
                f"{path}: no episodes; --episode {self.episode} expects a LeRobot data set"
            )


WHOLE = Part()


@dataclass(frozen=True)
class Parts:
    """What a file holds several of. options: the value of a ``Part``'s field -> words for it;
    taken: the value that was read, empty where none was."""

    kind: Literal["topic", "bus", "episode"]
    options: dict[str, str]
    taken: str

    @property
    def another(self) -> str:
        """How the command line asks for another one."""
        if self.kind != "episode":
            return "--topic NAME takes another"
        return "--episode N takes another, --episode all each as a run of its own"


class Undecided(UserError):
    """Several recordings, and nothing that tells which one is meant."""

    def __init__(self, message: str, parts: Parts) -> None:
        super().__init__(message)
        self.parts = parts
