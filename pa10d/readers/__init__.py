"""Recordings from other programs: any file that people have, as samples of a robot."""

from pa10d.readers.read import read_recording

__all__ = ["read_recording"]
