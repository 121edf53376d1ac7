"""Modules are loaded without a look for garbage: there is none yet."""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Iterator


@contextlib.contextmanager
def loading() -> Iterator[None]:
    """Around imports that make many classes: of a daemon's, every seventh second went into looking
    again and again through what stays for good."""
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if before:
            gc.enable()
