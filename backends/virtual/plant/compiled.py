"""Compiled code whose disk cache belongs to the exact sources that it is built from.

numba's cache looks only at the file of the outermost function, while the plant's step is put
together from many modules; and it cannot read an index that names classes of an older version. So
the cache's file name carries a digest of all modules of this folder.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import IndexDataCacheFile

inner = numba.njit(error_model="numpy")


@cache
def sources_digest(folder: Path = Path(__file__).parent) -> str:
    """Changes with any module of the folder."""
    digest = hashlib.sha256()
    for source in sorted(folder.glob("*.py")):
        digest.update(source.name.encode() + source.read_bytes())
    return digest.hexdigest()[:16]


def entry(function: Callable[..., Any]) -> Any:
    """Compile a function that Python calls; on disk where there is a place for it."""
    try:
        dispatcher = numba.njit(cache=True, error_model="numpy", nogil=True)(function)
    except RuntimeError:  # neither the package's folder nor a user's can be written
        return numba.njit(error_model="numpy", nogil=True)(function)
    on_disk = dispatcher._cache
    on_disk._cache_file = IndexDataCacheFile(
        cache_path=on_disk._cache_path,
        filename_base=f"{on_disk._impl.filename_base}-{sources_digest()}",
        source_stamp=sources_digest(),
    )
    return dispatcher
