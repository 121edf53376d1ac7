"""Runs and models of one data folder."""

from __future__ import annotations

import os
from dataclasses import dataclass

from pa10d.store import RunStore
from pa10d.store.models import ModelStore


@dataclass(frozen=True)
class Library:
    """What an analysis reads from and writes to."""

    runs: RunStore
    models: ModelStore


def open_library(data: str | os.PathLike[str] | None = None) -> Library:
    """The folder given, else PA10D_DATA, else the user's own."""
    return Library(RunStore(data), ModelStore(data))
