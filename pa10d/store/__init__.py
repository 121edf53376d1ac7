"""Runs on disk: the only room that knows their file formats."""

from pa10d.store.channels import Channels, CommandedMotion, Samples
from pa10d.store.run_info import RunInfo, Status
from pa10d.store.run_reader import StoredRun
from pa10d.store.run_writer import RunWriter
from pa10d.store.runs import RunStore

__all__ = [
    "Channels",
    "CommandedMotion",
    "RunInfo",
    "RunStore",
    "RunWriter",
    "Samples",
    "Status",
    "StoredRun",
]
