"""How files of different kinds begin, told without the packages that read them."""

from __future__ import annotations

import re
import sqlite3
from contextlib import closing
from pathlib import Path

from pa10d.common.errors import UserError

MCAP, SQLITE, ROS1 = b"\x89MCAP", b"SQLite format 3", b"#ROSBAG"
BAGS = (MCAP, SQLITE, ROS1)
STREAM = b"\xff\xff\xff\xff"
"""How Arrow's stream begins, which has no name of its own at its head."""
MDF = b"MDF     "
BINARY = (*BAGS, b"PAR1", b"ARROW1", b"MATLAB", b"\x89HDF", b"\x93NUMPY", b"PK\x03\x04", b"LOGG",
          MDF, STREAM)  # fmt: skip
"""How files begin that are no text."""
CAN_CSV = b"timestamp,arbitration_id,extended,remote,error,dlc,data"
"""The header that python-can writes."""


def is_can_csv(head: bytes) -> bool:
    """A CAN log as CSV: frames, not samples."""
    return head.removeprefix(b"\xef\xbb\xbf").startswith(CAN_CSV)


def is_can_database(path: Path) -> bool:
    """A SQLite file whose messages are frames, not a bag's."""
    try:
        with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as base:
            columns = {row[1] for row in base.execute("PRAGMA table_info(messages)")}
    except sqlite3.Error:
        return False
    return "arbitration_id" in columns


POINTER = b"version https://git-lfs.github.com/"
_PAGE = re.compile(rb"\s*<(!doctype html|html|head)\b", re.I)


def refuse_stand_in(path: Path, head: bytes) -> None:
    """UserError for what a download leaves where the recording itself did not come."""
    if head.startswith(POINTER):
        raise UserError(
            f"{path}: Git LFS' pointer to a recording; expected the file itself, by git lfs pull"
        )
    if _PAGE.match(head):
        raise UserError(
            f"{path}: a web page; expected the recording that the page offers for download"
        )
