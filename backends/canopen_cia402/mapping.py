"""PDO mapping by SDO, and what the drive made of it."""

from __future__ import annotations

from backends.canopen_cia402.layout import COMMAND, FEEDBACK, Layout, layout_of, mapping_word
from backends.canopen_cia402.objects import declared
from backends.canopen_cia402.remote import Remote, SetupError

INVALID = 1 << 31
MOST = 0x200  # PDOs in each direction
SYNCHRONOUS = 1  # transmission type: every SYNC
TIMERS = {3: "inhibit time", 5: "event timer", 6: "SYNC start value"}  # by sub-index


def map_pdos(remote: Remote) -> tuple[Layout, Layout]:
    """Both PDOs, written step by step as CiA 301 asks.

    canopen's PdoMap.save is not used: where a mapping is declared as an array (not a record), it
    takes the number of entries that it has just set to zero and writes none.
    """
    _silence_other_pdos(remote)
    return _map(remote, 0x1400, COMMAND, 0x200), _map(remote, 0x1800, FEEDBACK, 0x180)


def _silence_other_pdos(remote: Remote) -> None:
    """Whoever set them up, none but ours writes to the drive or fills the bus. Behind those that
    its EDS has more are asked for until there is none."""
    left = []
    for first, name in ((0x1400, "RPDO"), (0x1800, "TPDO")):
        more = True
        for index in range(first + 1, first + MOST):
            told = declared(remote.node, index)
            if not (told or more):
                continue
            cob_id = remote.read(index, 1)
            more = told or cob_id is not None
            if cob_id is None or cob_id & INVALID:
                continue
            problem = remote.write(index, cob_id | INVALID, 1)
            if not (remote.read(index, 1) or 0) & INVALID:
                left.append(f"{name} {index - first + 1} (0x{index:04X}) stays on: {problem}")
    if left:
        raise SetupError(left)


def _map(
    remote: Remote, communication: int, wanted: tuple[tuple[int, int], ...], base: int
) -> Layout:
    mapping, cob_id = communication + 0x200, base + remote.node.id
    steps = [(communication, 1, cob_id | INVALID), (communication, 2, SYNCHRONOUS)]
    steps += [(communication, sub, 0) for sub in TIMERS if remote.read(communication, sub)]
    steps += [(mapping, 0, 0)]
    words = [mapping_word(index, bits) for index, bits in wanted]
    steps += [(mapping, k + 1, word) for k, word in enumerate(words)]
    steps += [(mapping, 0, len(words)), (communication, 1, cob_id)]
    refused = [
        f"0x{index:04X}:{sub} {problem}"
        for index, sub, value in steps
        if (problem := remote.write(index, value, sub))
    ]
    try:  # what counts is what the drive has now: a fixed mapping may serve just as well
        return _read_back(remote, communication, wanted, cob_id)
    except ValueError as error:
        name = "RPDO 1" if communication == 0x1400 else "TPDO 1"
        because = f" ({', '.join(refused)})" if refused else ""
        raise SetupError([f"{name} as read back from the drive: {error}{because}"]) from error


def _read_back(
    remote: Remote, communication: int, wanted: tuple[tuple[int, int], ...], expected: int
) -> Layout:
    cob_id, kind = remote.read(communication, 1), remote.read(communication, 2)
    if cob_id is None or cob_id & (INVALID | 0x7FF) != expected:
        shown = "nothing" if cob_id is None else f"0x{cob_id:X}"
        raise ValueError(f"COB-ID {shown}, expected 0x{expected:X}")
    if kind != SYNCHRONOUS:
        raise ValueError(f"transmission type {kind}, expected 1 (every SYNC)")
    for sub, name in TIMERS.items():
        if left := remote.read(communication, sub):
            raise ValueError(f"{name} (0x{communication:04X}:{sub}) stays at {left}, expected 0")
    mapping = communication + 0x200
    words = [remote.read(mapping, k + 1) or 0 for k in range(remote.read(mapping) or 0)]
    return layout_of(words, wanted, exactly=communication == 0x1400)
