"""A folder that somebody packed: a bag or a data set as .tar.gz or .zip, unpacked beside it."""

from __future__ import annotations

import tarfile
import tempfile
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

from pa10d.common.errors import UserError
from pa10d.readers.packed import DAMAGED, ZIP, first_bytes, inner_head, of_somebody, unpacked
from pa10d.store.csv_locate import most_unpacked

TAR, AT = b"ustar", 257  # where every tar of today says that it is one
MOST = 20_000  # files
ALONE = (
    ".csv", ".tsv", ".parquet", ".feather", ".arrow", ".mat", ".npz", ".npy", ".h5", ".hdf5",
    ".bag", ".blf", ".asc", ".trc", ".mf4",
)  # fmt: skip
"""What may lie beside notes and pictures."""
ROOTS = ("metadata.yaml", "meta/info.json")
"""What lies at the root of a bag's folder, of a data set."""


def is_archive(path: Path) -> bool:
    """A tar, packed or not, or a .zip of several files."""
    if first_bytes(path, 4) == ZIP:
        if path.suffix.lower() == ".npz":
            return False
        try:
            with zipfile.ZipFile(path) as archive:
                return len(of_somebody(archive.namelist())) > 1
        except DAMAGED:
            return False  # said by who unpacks it
    try:
        head = inner_head(path, AT + len(TAR))
    except UserError:
        return False
    return head[AT:] == TAR


@contextmanager
def unpacked_recording(path: Path) -> Iterator[Path]:
    """The file or folder in it that is a recording; gone when they are done."""
    with tempfile.TemporaryDirectory(prefix="pa10d-unpacked-") as place:
        folder = Path(place)
        try:
            names = _unzip(path, folder) if first_bytes(path, 4) == ZIP else _untar(path, folder)
        except (*DAMAGED, tarfile.TarError, RuntimeError, NotImplementedError) as error:
            said = (str(error).strip() or type(error).__name__).splitlines()[0][:120]
            raise UserError(
                f"{path}: cannot be unpacked ({said}); expected a whole archive without a password"
            ) from error
        yield folder / _recording_in(path, names)


def _unzip(path: Path, folder: Path) -> list[str]:
    with zipfile.ZipFile(path) as archive:
        infos = [i for i in archive.infolist() if of_somebody([i.filename])]
        _refuse_bombs(path, [info.file_size for info in infos])
        for info in infos:
            archive.extract(info, folder)  # which leaves out whatever leads out of the folder
        return [info.filename for info in infos]


def _untar(path: Path, folder: Path) -> list[str]:
    with unpacked(path) as raw, tarfile.open(fileobj=raw, mode="r|") as archive:
        names: list[str] = []
        sizes: list[int] = []
        for member in archive:
            if member.isdir() or not of_somebody([member.name]):
                continue
            sizes.append(member.size)
            _refuse_bombs(path, sizes)
            archive.extract(member, folder, filter="data")
            names.append(member.name)
        return names


def _refuse_bombs(path: Path, sizes: Sequence[int]) -> None:
    most = most_unpacked(path)
    if sum(sizes) > most:
        raise UserError(f"{path}: becomes more than {most} bytes; expected a recording")
    if len(sizes) > MOST:
        raise UserError(f"{path}: an archive of more than {MOST} files; expected a recording")


def _recording_in(path: Path, names: Sequence[str]) -> str:
    """The only file, the only folder with a bag or a data set, or the folder of all files."""
    plain = [str(PurePosixPath(name)) for name in names]
    if len(plain) == 1:
        return plain[0]
    roots = {
        name.removesuffix(mark).rstrip("/")
        for name in plain
        for mark in ROOTS
        if name == mark or name.endswith(f"/{mark}")
    }
    bags = {str(PurePosixPath(name).parent) for name in plain if name.endswith((".db3", ".mcap"))}
    folders = roots or bags or {name for name in plain if name.lower().endswith(ALONE)}
    if "xl/workbook.xml" in plain:
        raise UserError(f"{path}: an Excel workbook; expected its sheet saved as CSV")
    if len(folders) != 1:
        found = f"{len(folders)} recordings" if folders else "no recording"
        raise UserError(
            f"{path}: an archive of {len(plain)} files with {found}; expected one recording in it"
        )
    return folders.pop()
