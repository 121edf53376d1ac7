"""Recordings from other programs: any file that people have, as samples of a robot."""

from pa10d.readers.read import read_recording, read_table
from pa10d.readers.table import Table, recording_of

__all__ = ["Table", "read_recording", "read_table", "recording_of"]
