"""Files that somebody has packed: told by their first bytes, whatever they are called."""

from __future__ import annotations

import bz2
import contextlib
import gzip
import lzma
import tempfile
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import IO, cast

from pa10d.common.errors import UserError
from pa10d.store.csv_locate import most_unpacked

GZIP, BZIP, XZ, ZSTD, ZIP = b"\x1f\x8b", b"BZh", b"\xfd7zXZ", b"\x28\xb5\x2f\xfd", b"PK\x03\x04"
DAMAGED = (OSError, EOFError, zlib.error, lzma.LZMAError, zipfile.BadZipFile)
PART = 1 << 20  # bytes
NOISE = ("__MACOSX", ".DS_Store", "Thumbs.db", "desktop.ini")


def first_bytes(path: Path, count: int) -> bytes:
    """By which a file's kind is told."""
    with path.open("rb") as file:
        return file.read(count)


def is_packed(path: Path) -> bool:
    """NumPy's .npz are ZIP archives, too, and read as what they are."""
    head = first_bytes(path, 6)
    if head.startswith(ZIP):
        return path.suffix.lower() != ".npz"
    return head.startswith((GZIP, BZIP, XZ, ZSTD))


@contextmanager
def unpacked(path: Path) -> Iterator[IO[bytes]]:
    """The file's bytes, whatever it was packed with."""
    head = first_bytes(path, 6)
    with contextlib.ExitStack() as stack:
        if head.startswith(GZIP):
            yield cast(IO[bytes], stack.enter_context(gzip.open(path)))
        elif head.startswith(BZIP):
            yield cast(IO[bytes], stack.enter_context(bz2.open(path)))
        elif head.startswith(XZ):
            yield cast(IO[bytes], stack.enter_context(lzma.open(path)))
        elif head.startswith(ZSTD):
            import pyarrow as pa

            yield stack.enter_context(pa.input_stream(str(path), compression="zstd"))
        elif head.startswith(ZIP):
            archive = stack.enter_context(zipfile.ZipFile(path))
            yield stack.enter_context(archive.open(_only_one(path, archive)))
        else:
            yield stack.enter_context(path.open("rb"))


def inner_head(path: Path, count: int) -> bytes:
    """The first bytes of what was packed; UserError where it cannot be unpacked."""
    try:
        with unpacked(path) as file:
            return bytes(file.read(count))
    except DAMAGED as error:
        raise _damaged(path) from error


def inner_name(path: Path) -> str:
    """What the packed file was called."""
    if first_bytes(path, 4) == ZIP:
        with zipfile.ZipFile(path) as archive:
            return Path(_only_one(path, archive)).name
    return path.stem


@contextmanager
def unpacked_file(path: Path) -> Iterator[Path]:
    """A file beside it for readers that need one; gone when they are done."""
    most, size = most_unpacked(path), 0
    with tempfile.TemporaryDirectory(prefix="pa10d-unpacked-") as folder:
        out = Path(folder) / inner_name(path)
        try:
            with unpacked(path) as file, out.open("wb") as plain:
                while part := file.read(PART):
                    size += len(part)
                    if size > most:
                        raise UserError(
                            f"{path}: becomes more than {most} bytes; expected a recording"
                        )
                    plain.write(part)
        except DAMAGED as error:
            raise _damaged(path) from error
        yield out


def of_somebody(names: Sequence[str]) -> list[str]:
    """An archive's files, without what desktops leave beside them."""
    return [
        name
        for name in names
        if not name.endswith("/") and not set(PurePosixPath(name).parts) & set(NOISE)
        and not PurePosixPath(name).name.startswith("._")
    ]  # fmt: skip


def _only_one(path: Path, archive: zipfile.ZipFile) -> str:
    there = of_somebody(archive.namelist())
    if len(there) != 1:
        raise UserError(f"{path}: an archive of {len(there)} files; expected one recording in it")
    return there[0]


def _damaged(path: Path) -> UserError:
    return UserError(f"{path}: the packed data are damaged; expected a whole file")
