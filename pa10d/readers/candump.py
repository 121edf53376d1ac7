"""Frames as candump writes them: to a file (``-l``, ``-L``), or to a terminal (``-t``)."""

from __future__ import annotations

import itertools
import re
import statistics
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType

import can

from pa10d.common.errors import UserError
from pa10d.readers.moments import seconds_since_first

_FRAME = re.compile(
    r"\s*(?:\((?P<stamp>[^()]+)\)\s+)?(?P<bus>\S+)\s+(?:[RT]X\s+\S+\s+\S+\s+)?"
    r"(?P<id>[0-9A-Fa-f]{8}|[0-9A-Fa-f]{3})"
    r"(?:#(?P<short>[0-9A-Fa-f]*|R\d?|#.*)(?:\s+[RT])?|\s+\[(?P<count>\d+)\](?P<long>.*))\s*"
)
_BYTES = re.compile(r"(?:\s+[0-9A-Fa-f]{2})*")
_ERROR = 0x2000_0000  # of an identifier that is none
LOOK = 4000  # frames by which stamps are told from differences
FALLING = 0.05  # share of stamps that fall, above which they are differences


def is_candump(head: bytes) -> bool:
    """Whether text begins with a frame of candump, behind comments."""
    for line in head.decode("utf-8", "replace").splitlines():
        if line.strip() and not line.startswith("#"):
            return _FRAME.fullmatch(line) is not None
    return False


class CandumpReader:
    """Messages in the order of the file; UserError names the line that is none."""

    def __init__(self, path: Path) -> None:
        self._path = Path(path)

    def __enter__(self) -> CandumpReader:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """Nothing is held open between two messages."""

    def __iter__(self) -> Iterator[can.Message]:
        messages = self._messages()
        first = list(itertools.islice(messages, LOOK))
        if not _differences([one.timestamp for one in first]):
            yield from itertools.chain(first, messages)
            return
        now = 0.0
        for one in itertools.chain(first, messages):
            now += one.timestamp
            one.timestamp = now
            yield one

    def _messages(self) -> Iterator[can.Message]:
        day: str | None = None
        with self._path.open(encoding="utf-8", errors="replace") as file:
            for number, line in enumerate(file, 1):
                if not line.strip() or line.startswith("#"):
                    continue
                found = _FRAME.fullmatch(line.rstrip("\n"))
                if found is None:
                    if not line.endswith("\n"):
                        return  # cut off
                    raise UserError(f"line {number}: expected a frame of candump")
                if found["stamp"] is None:
                    raise UserError("frames without stamps; expected candump -l, -ta or -tz")
                day = day or found["stamp"]
                yield _message(found, _seconds(found["stamp"], day, number))


def _differences(stamps: Sequence[float]) -> bool:
    """Whether each is the time since the frame before (``-td``): they fall, and come to nothing."""
    falls = sum(later < one for one, later in itertools.pairwise(stamps))
    if falls <= FALLING * len(stamps):
        return False
    half = len(stamps) // 2
    early, late = (statistics.median(some) - min(stamps) for some in (stamps[:half], stamps[half:]))
    return late < 2 * early


def _seconds(stamp: str, first: str, number: int) -> float:
    try:
        return float(stamp)
    except ValueError:
        since = seconds_since_first([first, stamp])  # -tA
        if since is None:
            raise UserError(f"line {number}: found the stamp {stamp!r}, expected s") from None
        return float(since[1])


def _message(found: re.Match[str], stamp: float) -> can.Message:
    number, short = int(found["id"], 16), found["short"]
    wide = len(found["id"]) > 3
    if short is None:
        listed = _BYTES.match(found["long"])
        text = "".join(listed[0].split()) if listed else ""
        remote = "remote" in found["long"]
        data = bytes.fromhex(text[: 2 * int(found["count"])])
    else:
        remote, short = short.startswith("R"), "" if short.startswith(("R", "#")) else short
        data = bytes.fromhex(short[: len(short) // 2 * 2])
    return can.Message(
        timestamp=stamp,
        arbitration_id=number & 0x1FFF_FFFF,
        is_extended_id=wide,
        is_error_frame=wide and bool(number & _ERROR),
        is_remote_frame=remote,
        data=b"" if remote else data[:8],
        channel=found["bus"],
    )
