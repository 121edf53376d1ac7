"""Recordings from other programs: any file that people have, as samples of a robot."""

from pa10d.readers.lerobot import episodes_of
from pa10d.readers.part import WHOLE, Part, Parts, Undecided
from pa10d.readers.read import read_recording, read_table
from pa10d.readers.table import ForeignTable, recording_of
from pa10d.readers.value_guess import guessed_by_value, one_block

__all__ = [
    "WHOLE",
    "ForeignTable",
    "Part",
    "Parts",
    "Undecided",
    "episodes_of",
    "guessed_by_value",
    "one_block",
    "read_recording",
    "read_table",
    "recording_of",
]
