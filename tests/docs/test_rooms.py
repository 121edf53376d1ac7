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


MIRRORS = (
    "face/",  # what ``import pa10d`` gives is called as the thing inside it
    "api/", "services/documents.py", "services/command_documents.py", "services/viewed.py",
    # and so is what clients are told
    "profile/profile.py", "store/model_schema.py",  # and what stands in files
    "effects/library/", "trajectory/kinds/",  # named by what nature or a person calls them
)  # fmt: skip
SHARED = {"Robot", "Term"}  # a program that an export writes has its own, and knows no other


def test_a_class_shares_its_name_with_none_of_another_room():
    """Two meanings of one word are one too many for whoever reads the second one first."""
    seen: dict[str, list[str]] = {}
    for path in sorted((ROOT / "pa10d").rglob("*.py")):
        place = path.relative_to(ROOT / "pa10d").as_posix()
        if not place.startswith(MIRRORS):
            for name in re.findall(r"^class ([A-Z]\w*)", path.read_text(encoding="utf-8"), re.M):
                seen.setdefault(name, []).append(place)
    twice = {name: places for name, places in seen.items() if len(places) > 1}
    assert {name: places for name, places in twice.items() if name not in SHARED} == {}
    assert set(twice) >= SHARED, "what is no longer shared is no longer listed"


LOOSE = {  # values that are no JSON and of any kind
    "pa10d/common/jsonable.py",  # what JSON objects are called
    "pa10d/effect_kit/carried.py", "pa10d/export/straight_line.py",  # names of a program that runs
    "pa10d/readers/matlab.py",  # structs of foreign files
    "pa10d/store/yaml_style.py",  # a dict with a style
}  # fmt: skip


def test_what_is_no_json_at_a_border_has_a_type():
    """``JsonObject`` is what passes through as it stands; all else has a class (decision 0208)."""
    loose = {
        path.relative_to(ROOT).as_posix()
        for room in ("pa10d", "backends")
        for path in (ROOT / room).rglob("*.py")
        if "dict[str, Any]" in path.read_text(encoding="utf-8")
    }
    assert loose == LOOSE
