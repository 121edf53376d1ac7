"""ROS 2 messages of fixed size as templates: constant CDR bytes and the places of the numbers.

A robot's joint names never change during a run, so neither does the size of its messages. One
message is packed once, with zeros; a block of messages is that template repeated, with stamps and
values written into it by numpy.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
Fields = Mapping[str, tuple[str, int]]  # name -> numpy format, byte offset in the message

_SEPARATOR = "=" * 80 + "\n"
DEFINITIONS = {
    "sensor_msgs/msg/JointState": (
        "std_msgs/Header header\nstring[] name\n"
        "float64[] position\nfloat64[] velocity\nfloat64[] effort\n"
        + _SEPARATOR
        + "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
        + _SEPARATOR
        + "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
    ),
    "std_msgs/msg/Float64": "float64 data\n",
    "std_msgs/msg/Float64MultiArray": (
        "std_msgs/MultiArrayLayout layout\nfloat64[] data\n"
        + _SEPARATOR
        + "MSG: std_msgs/MultiArrayLayout\nstd_msgs/MultiArrayDimension[] dim\nuint32 data_offset\n"
        + _SEPARATOR
        + "MSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n"
    ),
}


@dataclass(frozen=True)
class Template:
    """One message of a type: its bytes with zeros for numbers, and where the numbers stand."""

    type: str
    cdr: bytes
    fields: Fields
    names: tuple[str, ...] = ()  # joint names (JointState)


class _Packer:
    """CDR alignment counts from behind the four bytes that announce the byte order."""

    def __init__(self) -> None:
        self.data = bytearray(CDR_LITTLE_ENDIAN)
        self.fields: dict[str, tuple[str, int]] = {}

    def align(self, size: int) -> None:
        self.data += bytes(-(len(self.data) - 4) % size)

    def number(self, name: str, code: str) -> None:
        self.align(struct.calcsize(code))
        self.fields[name] = (f"<{code}", len(self.data))
        self.data += bytes(struct.calcsize(code))

    def count(self, value: int) -> None:
        self.align(4)
        self.data += struct.pack("<I", value)

    def text(self, value: str) -> None:
        encoded = value.encode() + b"\0"
        self.count(len(encoded))
        self.data += encoded

    def doubles(self, name: str, n: int) -> None:
        self.count(n)
        if n:
            self.align(8)
            self.fields[name] = (f"({n},)<f8", len(self.data))
            self.data += bytes(8 * n)


def joint_state(names: Sequence[str], velocity: bool) -> Template:
    """sensor_msgs/JointState with position and effort, and velocity where there is one."""
    packer = _Packer()
    packer.number("sec", "i")
    packer.number("nanosec", "I")
    packer.text("")  # frame_id
    packer.count(len(names))
    for name in names:
        packer.text(name)
    packer.doubles("position", len(names))
    packer.doubles("velocity", len(names) if velocity else 0)
    packer.doubles("effort", len(names))
    return Template("sensor_msgs/msg/JointState", bytes(packer.data), packer.fields, tuple(names))


def float64() -> Template:
    """std_msgs/Float64: one number, stamped by the bag alone."""
    packer = _Packer()
    packer.number("data", "d")
    return Template("std_msgs/msg/Float64", bytes(packer.data), packer.fields)


def float64_array(label: str, n: int) -> Template:
    """std_msgs/Float64MultiArray with one dimension, labelled."""
    packer = _Packer()
    packer.count(1)
    packer.text(label)
    packer.count(n)
    packer.count(n)
    packer.count(0)  # data_offset
    packer.doubles("data", n)
    return Template("std_msgs/msg/Float64MultiArray", bytes(packer.data), packer.fields)


class _Parser:
    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 4
        self.fields: dict[str, tuple[str, int]] = {}

    def align(self, size: int) -> None:
        self.at += -(self.at - 4) % size

    def number(self, name: str, code: str) -> None:
        self.align(struct.calcsize(code))
        self.fields[name] = (f"<{code}", self.at)
        self.at += struct.calcsize(code)

    def count(self) -> int:
        self.align(4)
        (value,) = struct.unpack_from("<I", self.data, self.at)
        self.at += 4
        return int(value)

    def text(self) -> str:
        size = self.count()
        value = self.data[self.at : self.at + size - 1].decode()
        self.at += size
        return value

    def doubles(self, name: str) -> None:
        n = self.count()
        if n:
            self.align(8)
            self.fields[name] = (f"({n},)<f8", self.at)
            self.at += 8 * n


def parse(message_type: str, cdr: bytes) -> Template:
    """The template that a message was made from; ValueError where it is none of ours."""
    parser = _Parser(cdr)
    names: tuple[str, ...] = ()
    try:
        if cdr[:4] != CDR_LITTLE_ENDIAN:
            raise ValueError("not little-endian CDR")
        if message_type == "sensor_msgs/msg/JointState":
            names = _parse_joint_state(parser)
        elif message_type == "std_msgs/msg/Float64":
            parser.number("data", "d")
        elif message_type == "std_msgs/msg/Float64MultiArray":
            for _ in range(parser.count()):
                parser.text()
                parser.count()
                parser.count()
            parser.count()
            parser.doubles("data")
        else:
            raise ValueError(f"messages of type {message_type}")
    except (struct.error, UnicodeDecodeError) as error:
        raise ValueError(f"a broken {message_type}") from error
    if parser.at > len(cdr):
        raise ValueError(f"a broken {message_type}")
    return Template(message_type, cdr, parser.fields, names)


def _parse_joint_state(parser: _Parser) -> tuple[str, ...]:
    parser.number("sec", "i")
    parser.number("nanosec", "I")
    parser.text()
    names = tuple(parser.text() for _ in range(parser.count()))
    for field in ("position", "velocity", "effort"):
        parser.doubles(field)
    return names
