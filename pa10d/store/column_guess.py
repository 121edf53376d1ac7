"""What the columns of a file may be, from their names: a ready ``--map`` line for a person."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Sequence

from pa10d.store.column_mapping import UNITS

WORDS = (
    ("dq", r"velocit|veloc|\bvel|speed|qdot|\bdq|\bqd\b|omega"),
    ("tau", r"effort|torque|\btau|\btrq|moment|\bmom"),
    ("i", r"current|\bcur|amp"),
    ("temp", r"temp"),
    ("q", r"position|\bpos|angle|\bang|\bq|theta|phi|joint"),
)
DEMANDED = re.compile(r"desired|target|command|\bcmd|\bref|setpoint|goal|error|\bdes", re.I)
TIMES = {"t", "time", "stamp", "timestamp", "seconds", "sec", "secs", "zeit"}
_NUMBER = re.compile(r"\d+")
_UNIT = re.compile(r"[\[(]([^\[\]()]+)[\])]\s*$|_(deg|rad|ms|us|ns|Nm|mNm|rpm)$")


def guess(names: Sequence[str], n: int) -> list[str]:
    """``COLUMN=FIELD`` options for a robot of n joints, as far as the names tell."""
    times = [name for name in names if _bare(name) in TIMES]
    rules = [f"{name}=time" for name in times[:1] if name != "time"]
    for field, columns in _families(names).items():
        if len(columns) < n or all(name == f"{field}{j}" for j, (name, _) in enumerate(columns, 1)):
            continue
        templates = {_template(column, first) for column, first in columns[:n]}
        if len(templates) == 1:
            rules.append(f"{templates.pop()}={field}")
        else:
            named = [(column, f"{field}{j}") for j, (column, _) in enumerate(columns[:n], 1)]
            rules += [f"{column}={one}" for column, one in named if column != one]
    return rules


def _families(names: Sequence[str]) -> dict[str, list[tuple[str, int]]]:
    """Field -> its columns with the number of the first joint, in the joints' order."""
    found: dict[str, list[tuple[int, str]]] = defaultdict(list)
    for name in names:
        number = _NUMBER.search(name)
        plain = re.sub(r"[_.\-/]", " ", name)
        if number is None or DEMANDED.search(plain):
            continue
        field = next((f for f, words in WORDS if re.search(words, plain, re.I)), None)
        if field is not None:
            found[field].append((int(number[0]), name))
    return {
        field: [(name, min(entries)[0]) for _, name in sorted(entries)]
        for field, entries in found.items()
    }


def _template(column: str, first: int) -> str:
    mark = "{n}" if first == 1 else "{n-1}" if first == 0 else None
    if mark is None:
        return column
    out = _NUMBER.sub(mark, column, count=1)
    unit = _UNIT.search(column)
    if unit and unit[2] in UNITS and UNITS[unit[2]] != 1.0:
        out += f"[{unit[2]}]"
    return out


def _bare(name: str) -> str:
    return re.sub(r"[\[(].*", "", name).strip().strip("_").lower()
