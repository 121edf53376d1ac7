"""That a drive stops its axis when the control PC dies: heartbeats, else node guarding."""

from __future__ import annotations

from dataclasses import dataclass, field

from backends.canopen_cia402.objects import LIFELINE, lack
from backends.canopen_cia402.remote import Remote
from backends.cia402 import Reaction
from pa10d.common.words import listed
from pa10d.profile import Drive, Risk

GUARD_TIME, LIFE_TIME_FACTOR = 0x100C, 0x100D
LIFE = 3  # guard times without a question, after which we count as lost


@dataclass
class Lifeline:
    """How a drive watches us. ``risks`` are those of the ``lacks`` that a profile has to accept."""

    guarded: bool = False
    heard: bool = True  # whether it tells in turn that it lives
    risks: dict[Risk, str] = field(default_factory=dict)
    lacks: list[str] = field(default_factory=list)


def be_watched(remote: Remote, master: int, silence_ms: int, heartbeat_ms: int) -> Lifeline:
    """Have node ``master``'s silence noticed and answered by a fault, by whatever the drive has."""
    made = Lifeline()
    problem = _watch(remote, master, silence_ms)
    if problem is not None:
        made.guarded = _guard(remote, heartbeat_ms)
        if not made.guarded:
            made.risks["unwatched"] = _sentence(0x1016, problem)
    if not made.guarded and (beat := remote.write(0x1017, heartbeat_ms)) is not None:
        made.heard = False
        made.lacks.append(_sentence(0x1017, beat))
    if (problem := remote.write(0x6007, Reaction.FAULT)) is not None:
        made.risks["unknown_reaction"] = _sentence(0x6007, problem)
    made.lacks[:0] = made.risks.values()
    return made


def _watch(remote: Remote, master: int, silence_ms: int) -> str | None:
    """By the first entry that is free, or was ours: whom else the drive watches, the module of an
    emergency stop say, it goes on to watch. None: done; else why not."""
    entries = {sub: remote.read(0x1016, sub) or 0 for sub in _entries(remote)}
    watched = {sub: value >> 16 & 0x7F for sub, value in entries.items() if value & 0xFFFF}
    for sub, node in watched.items():
        if node == master:  # which an earlier master left: it would keep ours out
            remote.write(0x1016, 0, sub)
    free = [sub for sub in entries if watched.get(sub, 0) in (0, master)]
    if not free:
        others = listed(sorted({str(node) for node in watched.values()}))
        return f"all it can watch is node {others}: set an entry of it to 0 if nobody is there"
    return remote.write(0x1016, master << 16 | silence_ms, free[0])


def _entries(remote: Remote) -> range:
    """Sub-indices that the drive has; it may not tell how many."""
    return range(1, max(remote.read(0x1016) or 0, 1) + 1)


def not_accepted(drive: Drive, risks: dict[Risk, str]) -> list[str]:
    """What stands between this drive and power: each risk that the profile does not name."""
    return [
        f"{sentence}: have another way to cut its power, then name the risk in this drive's entry "
        f"of the profile: accepted_risks: [{risk}]"
        for risk, sentence in risks.items()
        if risk not in drive.accepted_risks
    ]


def _guard(remote: Remote, guard_ms: int) -> bool:
    """Node guarding instead; a node that sends heartbeats would not answer to it."""
    if not all(remote.has(index) for index in (GUARD_TIME, LIFE_TIME_FACTOR)):
        return False
    beats_no_more = remote.ensure(0x1017, 0) is None
    asked = remote.write(GUARD_TIME, guard_ms) is None
    return beats_no_more and asked and remote.write(LIFE_TIME_FACTOR, LIFE) is None


def _sentence(index: int, problem: str) -> str:
    if problem == "absent":
        return lack(index)
    name, meaning = LIFELINE[index]
    return f"{name} (0x{index:04X}): {problem}; {meaning}"
