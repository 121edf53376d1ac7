"""Device descriptions: the package's own, and where a profile's are."""

from __future__ import annotations

import pickle
from functools import lru_cache
from pathlib import Path

import canopen

from pa10d.common.errors import UserError
from pa10d.profile import Profile

OWN_EDS = Path(__file__).parent / "pa10d_drive.eds"


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
def _declared(path: Path, _content: bytes, node: int) -> bytes:
    """Pickled: whoever asks changes their own. A file that is the same is not parsed again, which
    takes 20 times as long, whenever an arm is connected."""
    return pickle.dumps(canopen.import_od(str(path), node))
