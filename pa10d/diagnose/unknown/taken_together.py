"""What foretells an error together, in words: ``joint 2's position and speed``.

Quantities are written as where they are made: ``q2``, ``dq2``, ``ddq2``, ``turn2`` (which way joint
2 turns), ``q2 0.4 s ago``, ``dq2 0.2 s before``, ``work2 0.5 s`` (how much it moved of late),
``turned2 5 s`` (which way), ``turn3·|dq2|`` and ``time``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from pa10d.common.words import listed

_OF_A_JOINT = re.compile(r"(q|dq|ddq|turn|work|turned)(\d+)(?: (\S+ s)(?: (?:ago|before))?)?")
_OF_TWO = re.compile(r"(turn\d+)·\|(dq\d+)\|")
_NOW = {"q": "position", "dq": "speed", "ddq": "acceleration", "turn": "direction"}
_THEN = {
    "q": "position {} before", "dq": "speed {} before", "work": "motion in the last {}",
    "turned": "direction over the last {}",
}  # fmt: skip


def together(names: Sequence[str]) -> str:
    """Each quantity once, by joints in the order in which they come."""
    of_joint: dict[str, list[str]] = {}
    for joint, what in (part for name in names for part in _parts(name)):
        told = of_joint.setdefault(joint, [])
        if what not in told:
            told.append(what)
    return listed([f"joint {joint}'s {listed(told)}" if joint else told[0]
                   for joint, told in of_joint.items()])  # fmt: skip


def _parts(name: str) -> Iterator[tuple[str, str]]:
    """Joint (from 1; empty where it is of none) and what of it."""
    both = _OF_TWO.fullmatch(name)
    for one in both.groups() if both else (name,):
        found = _OF_A_JOINT.fullmatch(one)
        if found is None:
            yield "", one
        else:
            kind, joint, ago = found.groups()
            yield joint, _THEN[kind].format(ago) if ago else _NOW[kind]
