"""What the columns of a file may be, from their names: a ready ``--map`` line for a person."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from pa10d.store.column_choices import Choice, rules_of
from pa10d.store.column_mapping import PER_JOINT, UNITS, own_unit

WORDS = {
    "dq": r"velocit|veloc|\b(act)?vel|speed|\bdq|\bqd(?![a-z])|(q|phi|theta) ?d(ot)?(?![a-z])|omega"
    r"|geschwindigkeit",
    "tau": r"effort|torque|\btau|\btrq|\bqfrc|moment|\bmom|\beff\b",
    "i": r"current|\bcur|\bamp(s|eres?)?\d*\b|\bstrom",
    "temp": r"temp",
    "q": r"position|\b(act)?pos|angle|\bang|\bq|theta|phi|winkel",
}
VAGUE = {"q": r"joint|\bstate|\b(axis|axe|achse|ax|j|a) ?\d"}  # where no name says more
MEASURED_IN = {
    "q": {"rad", "mrad", "deg", "°", "rev"}, "dq": {"rad/s", "deg/s", "°/s", "rpm", "rev/s"},
    "tau": {"Nm", "N·m", "N.m", "N*m", "mNm", "Nmm", "kNm", "cNm", "Ncm"}, "i": {"A", "mA"},
    "temp": {"°C", "degC"},
}  # fmt: skip
"""What the unit behind a name tells, where its words tell nothing: A1 [°], M1 [Nm]."""
DEMANDED = re.compile(
    r"desired|demand|target|command|\bcmd|\bref|set ?point|goal|error|\bdes|\baction|planned|wanted"
    r"|\bsoll|\bd\d*\b",
    re.I,
)
"""A lone d, too: q_d and tau_J_d are what Franka's arms are asked for."""
NOT_ALL = re.compile(
    r"\bext|external|gravity|coriolis|residual|contact|feed ?forward|\bff\b|passive|constraint"
    r"|\bbias",
    re.I,
)
"""Words of torques that are not, or not all, that the motor gave."""
ACCELERATION = re.compile(r"accel|\bacc|\bddq|(q|phi|theta) ?dd(ot)?(?![a-z])|beschleunigung", re.I)
AT_MOTOR = re.compile(r"motor|rotor|\braw|\benc(oder)?\b|drive side", re.I)
TIMES = {
    "t", "time", "times", "stamp", "stamps", "timestamp", "timestamps", "seconds", "sec", "secs",
    "zeit", "ts", "tout", "x_value",
}  # fmt: skip
_A_TIME = re.compile(r"time|stamp|zeit|\bdate\b|\bclock\b|elapsed|\bduration\b", re.I)
_HUMP = re.compile(r"(?<=[a-z])(?=[A-Z][a-z]{2})")
_NUMBER = re.compile(r"\d+")
_UNIT = re.compile(r"_(deg|mrad|rad|ms|us|ns|Nm|mNm|cNm|rpm)(_s|_?ps)?\d*$")


def guess(names: Sequence[str], n: int) -> list[str]:
    """``COLUMN=FIELD`` options for a robot of n joints, as far as the names tell."""
    return rules_of(guessed(names, n), n)


def guessed(
    names: Sequence[str], n: int, joints: Sequence[str] = (), *, demanded: bool = False
) -> list[Choice]:
    """What the names say. joints: the robot's own names for them; demanded: look at what was asked
    for (desired, command …), and at nothing else."""
    out = []
    if not demanded:
        times = [name for name in names if _bare(name) in TIMES]
        times = times or [name for name in names if tells_time(name)]
        out = [Choice(name, "time", unit_in(name)) for name in sorted(times, key=_not_time)[:1]]
    taken = {choice.column for choice in out}
    open_to = [
        name for name in names
        if name not in taken and was_asked_for(name) == demanded and not _is_a_part(name)
        and not ACCELERATION.search(_plain(name))
    ]  # fmt: skip
    for field in PER_JOINT:
        for tells in (_by_words, _by_unit, _by_a_vague_word):
            there = [name for name in open_to if tells(field, name)]
            found = next(_in_order(field, there, n, joints), None)
            if found is not None:
                named = enumerate(found, 1)
                out += [Choice(name, f"{field}{j}", unit_in(name)) for j, name in named]
                break
    return out


def tells_time(name: str) -> bool:
    """Whether a column is called like stamps."""
    return _bare(name) in TIMES or bool(_A_TIME.search(_plain(name)))


def was_asked_for(name: str) -> bool:
    """Whether a column is called like something that a controller wants, not a measurement."""
    return bool(DEMANDED.search(_plain(name)))


def _is_a_part(name: str) -> bool:
    """Whether a torque is called like one that is not all that the motor gave."""
    plain = _plain(name)
    return bool(NOT_ALL.search(plain) and re.search(WORDS["tau"], plain, re.I))


def unit_in(name: str) -> str:
    """The unit that a column's name ends in, where it is not SI."""
    found = own_unit(name)
    if not found and (match := _UNIT.search(name)):
        found = f"{match[1]}/s" if match[2] else match[1]
    return found if UNITS.get(found, 1.0) != 1.0 else ""


def _in_order(
    field: str, names: Sequence[str], n: int, joints: Sequence[str]
) -> Iterator[list[str]]:
    """Ways to deal the names out to n joints, the surest first: by the fields' own names, by a
    number that counts the joints, by the joints' names, by their order in the file."""
    own = [f"{field}{j}" for j in range(1, n + 1)]
    if all(name in names for name in own):
        yield own
    groups: dict[str, dict[int, str]] = {}
    for name in names:
        for number in _NUMBER.finditer(name):
            key = f"{name[: number.start()]}\0{name[number.end() :]}"
            groups.setdefault(key, {})[int(number[0])] = name
    at_the_joint_first = sorted(groups.values(), key=_is_at_the_motor)
    for group in at_the_joint_first:
        for start in (1, 0):
            if all(start + j in group for j in range(n)):
                yield [group[start + j] for j in range(n)]
    called = [[name for name in names if joint.lower() in name.lower()] for joint in joints]
    if len(called) == n and all(len(found) == 1 for found in called):
        yield [found[0] for found in called]
    if len(names) == n and not any(_NUMBER.search(name) for name in names):
        yield list(names)


def _is_at_the_motor(group: Mapping[int, str]) -> bool:
    """Whether columns say that they are of the motor's side, where a file has both sides."""
    return any(AT_MOTOR.search(_plain(name)) for name in group.values())


def _by_words(field: str, name: str) -> bool:
    """Whether the first field whose words the name has is this one."""
    return next((one for one, words in WORDS.items() if _has(name, words)), "") == field


def _by_unit(field: str, name: str) -> bool:
    """Whether a name that tells nothing has a unit behind it that this field alone is in."""
    return own_unit(name) in MEASURED_IN[field] and not any(_has(name, w) for w in WORDS.values())


def _by_a_vague_word(field: str, name: str) -> bool:
    """Whether it has one, and neither a word of any field nor a unit of another."""
    vague = field in VAGUE and _has(name, VAGUE[field])
    measured = own_unit(name)
    others = [units for one, units in MEASURED_IN.items() if one != field]
    return (
        vague
        and not any(measured in units for units in others)
        and not any(_has(name, words) for words in WORDS.values())
    )


def _has(name: str, words: str) -> bool:
    return bool(re.search(words, _plain(name), re.I))


def _plain(name: str) -> str:
    """Words apart, also those of MsrJntPos and qCmd."""
    return re.sub(r"[_.\-/]", " ", _HUMP.sub(" ", name))


def _not_time(name: str) -> bool:
    return name != "time"


def _bare(name: str) -> str:
    bare = re.sub(r"[\[(].*", "", name).strip().strip("_").lower()
    return re.sub(r"_(ms|us|ns|s)$", "", bare)
