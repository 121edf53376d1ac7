"""Where in a PDO the values of the cycle stand, as the drive says and not as we assume."""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct

COMMAND = ((0x6040, 16), (0x6071, 16))  # controlword, target torque
FEEDBACK = ((0x6064, 32), (0x6077, 16), (0x6041, 16))  # position, torque, statusword
CODES = {0x6040: "H", 0x6071: "h", 0x6064: "i", 0x6077: "h", 0x6041: "H"}


def mapping_word(index: int, bits: int) -> int:
    """An entry of 0x1600 or 0x1A00, sub-index 0."""
    return index << 16 | bits


@dataclass(frozen=True)
class Layout:
    """A compiled PDO. ``order[k]`` is the place of the k-th wanted value among the unpacked."""

    struct: Struct
    order: tuple[int, ...]

    @property
    def size(self) -> int:
        return self.struct.size


def layout_of(words: list[int], wanted: tuple[tuple[int, int], ...], exactly: bool) -> Layout:
    """The layout behind mapping entries read from a drive.

    ValueError says what is wrong: an object missing, misplaced, or (``exactly``) one too many.
    """
    places: dict[int, int] = {}
    code, bits = "<", 0
    for word in words:
        index, sub, size = word >> 16, word >> 8 & 0xFF, word & 0xFF
        if size % 8:
            raise ValueError(f"0x{index:04X} takes {size} bits, expected whole bytes")
        if (index, size) in wanted and sub == 0 and index not in places:
            places[index] = len(places)
            code += CODES[index]
        elif exactly:
            raise ValueError(f"0x{index:04X}:{sub} is mapped too and nobody would fill it")
        else:
            code += f"{size // 8}x"
        bits += size
    if missing := [f"0x{index:04X}" for index, _ in wanted if index not in places]:
        raise ValueError(f"{', '.join(missing)} not mapped")
    if bits > 64:
        raise ValueError(f"{bits} bits, a frame carries 64")
    return Layout(Struct(code), tuple(places[index] for index, _ in wanted))
