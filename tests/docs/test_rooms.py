"""The page for contributors names every room that there is, and none that there is not."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_every_room_is_described():
    page = (ROOT / "CONTRIBUTING.md").read_text()
    table = page.partition("## Rooms")[2].partition("\nInside")[0]
    told = {
        name
        for row in table.splitlines()
        if row.startswith("|")
        for name in re.findall(r"`(\w+)`", row.split("|")[1])
    }
    rooms = {path.parent.name for path in (ROOT / "pa10d").glob("*/__init__.py")}
    assert told == rooms | {"client", "replay"}
