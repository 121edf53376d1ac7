"""Device descriptions: the package's own, and where a profile's are."""

from __future__ import annotations

import codecs
import pickle
from functools import lru_cache
from io import StringIO
from pathlib import Path

import canopen

from pa10d.common.errors import UserError
from pa10d.profile import Profile

OWN_EDS = Path(__file__).parent / "pa10d_drive.eds"
TO_MAPPING = 0x200  # from a PDO's communication to its mapping
UTF_16_MARKS = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def eds_path(profile: Profile, axis: int) -> Path:
    """The device description of one drive: the profile's, or the package's own."""
    eds = profile.drives[axis].eds if profile.drives else None
    return OWN_EDS if eds is None else profile.path.parent / eds


def load_eds(path: Path, node: int) -> canopen.ObjectDictionary:
    """The object dictionary that an EDS or DCF declares, for one node id."""
    if not path.is_file():
        raise UserError(f"{path}: no such EDS file; expected the drive's device description")
    try:
        found: canopen.ObjectDictionary = pickle.loads(_declared(path, path.read_bytes(), node))
        return found
    except Exception as error:  # the parser raises whatever it meets first
        raise UserError(f"{path}: cannot be read as an EDS or DCF: {error}") from error


@lru_cache(maxsize=64)
def _declared(path: Path, content: bytes, node: int) -> bytes:
    """Pickled: whoever asks changes their own. A file that is the same is not parsed again, which
    takes 20 times as long, whenever an arm is connected."""
    found = canopen.import_od(_Named(content, str(path)), node)
    for index in [index for index in found if _is_pdo(index) and index + TO_MAPPING not in found]:
        del found[index]  # canopen wants both of every PDO
    return pickle.dumps(found)


class _Named(StringIO):
    """A file's text, as makers write it: with a byte order mark, or in the code page of Windows,
    in which ``µ`` and ``°`` are no UTF-8."""

    def __init__(self, content: bytes, name: str) -> None:
        try:
            text = content.decode("utf-16" if content[:2] in UTF_16_MARKS else "utf-8-sig")
        except UnicodeDecodeError:
            text = content.decode("cp1252", errors="replace")
        super().__init__(text, newline=None)
        self.name = name


def _is_pdo(index: int) -> bool:
    return 0x1400 <= index < 0x1600 or 0x1800 <= index < 0x1A00
