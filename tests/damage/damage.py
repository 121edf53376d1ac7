"""Files as no writer leaves them: bits flipped, cut, doubled, types exchanged."""

from __future__ import annotations

import re

import numpy as np

WRONG = [
    b"null", b"true", b"-1", b"0", b"1e999", b".nan", b"[]", b"{}", b"''", b'"../../x"', b"[[1]]",
    b"9" * 400, b"text", b"2001-02-30", b"{a: 1}", b"- 1", b"\xff\xfe", b"*a", b"&a [*a]",
    b"!!int x", "٣".encode(), b"1_000", b"0x10", b"1:30", b"-0.0", b"1e-320", b"\x00", b"nan",
    b"inf", b"%s",
]  # fmt: skip
_VALUE = re.compile(rb"(?<=[:,=\[ \"'>])[-+.\w]+(?=[,\]\n\"'< ])")


def damaged(data: bytes, rng: np.random.Generator, text: bool) -> bytes:
    """One of many ways to be wrong."""
    ways = [_flipped, _cut, _doubled, _left_out, _noise]
    ways += [_exchanged, _exchanged, _exchanged, _lines_shuffled] if text else [_flipped, _zeros]
    for _ in range(int(rng.integers(1, 3))):
        data = ways[rng.integers(len(ways))](data, rng) or b"x"
    return data


def _place(data, rng):
    return int(rng.integers(len(data)))


def _flipped(data, rng):
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 5))):
        out[_place(data, rng)] ^= 1 << int(rng.integers(8))
    return bytes(out)


def _cut(data, rng):
    return data[: _place(data, rng)]


def _span(data, rng):
    first = _place(data, rng)
    return first, min(len(data), first + int(rng.integers(1, 200)))


def _doubled(data, rng):
    first, last = _span(data, rng)
    return data[:last] + data[first:last] + data[last:]


def _left_out(data, rng):
    first, last = _span(data, rng)
    return data[:first] + data[last:]


def _noise(data, rng):
    first, last = _span(data, rng)
    return data[:first] + rng.bytes(last - first) + data[last:]


def _zeros(data, rng):
    first, last = _span(data, rng)
    return data[:first] + bytes(last - first) + data[last:]


def _exchanged(data, rng):
    """Another value, often of another type, in the place of one."""
    values = list(_VALUE.finditer(data))
    if not values:
        return data
    found = values[rng.integers(len(values))]
    return data[: found.start()] + WRONG[rng.integers(len(WRONG))] + data[found.end() :]


def _lines_shuffled(data, rng):
    lines = data.splitlines(keepends=True)
    k = int(rng.integers(len(lines)))
    lines.insert(int(rng.integers(len(lines))), lines.pop(k))
    return b"".join(lines)
