"""The numbers that the diagnosis was given stand together, and all of them work."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pa10d.diagnose.constants as constants
from pa10d.diagnose.unknown import foretold, structure

ROOM = Path(constants.__file__).parent
NAMES = re.findall(r"^([A-Z_]+) = .*$", Path(constants.__file__).read_text(), re.MULTILINE)


def _given_here(path: Path) -> list[str]:
    """Names of module-level numbers, or tuples of them."""
    return [
        target.id
        for line in ast.parse(path.read_text()).body
        if isinstance(line, ast.Assign)
        for given in line.targets
        for target in (given.elts if isinstance(given, ast.Tuple) else [given])
        if isinstance(target, ast.Name) and target.id.isupper()
        for value in [line.value.elts[0] if isinstance(line.value, ast.Tuple) else line.value]
        if isinstance(value, ast.Constant) and isinstance(value.value, int | float)
    ]


def test_no_other_module_of_the_diagnosis_has_numbers_of_its_own():
    elsewhere = {p.name: _given_here(p) for p in ROOM.rglob("*.py") if p.name != "constants.py"}
    assert not {name: found for name, found in elsewhere.items() if found}


def test_what_foretells_looks_as_far_back_as_maps_do(monkeypatch):
    """A number that stands twice is two numbers."""
    for room in (structure, foretold):
        monkeypatch.setattr(room, "MAP_MEMORIES", (0.3, 1.5))
    ago = {name for names in foretold.sets_of(0, 2) for name in names if name.endswith("ago")}
    assert ago == {f"q{j} {s} s ago" for j in (1, 2) for s in (0.3, 1.5)}


def test_every_number_is_used():
    texts = (p.read_text() for p in ROOM.parent.rglob("*.py") if p.name != "constants.py")
    words = {word for text in texts for word in re.findall(r"\w+", text)}
    assert len(NAMES) > 60
    assert not [name for name in NAMES if name not in words]
