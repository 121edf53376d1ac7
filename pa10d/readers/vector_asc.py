"""Vector's text logs whose stamps are the time since the line before: python-can reads them as if
they were the time since the begin."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

ENDING = ".asc"
HEAD = 20  # lines within which the header says it
_RELATIVE = re.compile(rb"^\s*base\s+\w+\s+timestamps\s+relative", re.IGNORECASE)
_STAMP = re.compile(rb"^(\s*)(\d+\.\d+)(?=\s)")


@contextmanager
def since_begin(path: Path) -> Iterator[Path]:
    """The log itself, or a copy of it in which every stamp counts from the begin."""
    if path.suffix.lower() != ENDING or not _is_relative(path):
        yield path
        return
    with TemporaryDirectory(prefix="pa10d-asc-") as folder:
        copy = Path(folder) / path.name
        now = 0.0
        with path.open("rb") as lines, copy.open("wb") as out:
            for line in lines:
                if _RELATIVE.match(line):
                    line = line.replace(b"relative", b"absolute")
                if found := _STAMP.match(line):
                    now += float(found[2])
                    line = b"%s%.6f%s" % (found[1], now, line[found.end() :])
                out.write(line)
        yield copy


def _is_relative(path: Path) -> bool:
    with path.open("rb") as lines:
        return any(_RELATIVE.match(line) for _, line in zip(range(HEAD), lines, strict=False))
