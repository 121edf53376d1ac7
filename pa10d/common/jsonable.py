"""Values of ours as strict JSON knows them."""

from __future__ import annotations

import dataclasses
import math
from functools import lru_cache
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, TypeVar, cast

if TYPE_CHECKING:
    from pydantic import TypeAdapter

T = TypeVar("T")

JsonObject = dict[str, Any]
"""A document at a border: it goes into a file, to a client or to another process as it stands. Who
needs to know what is in it parses it into a type of its own, once."""


def parsed(kind: type[T], document: Any) -> T:
    """The value of a dataclass that ``plain`` made a document of, in whatever process; further
    fields are passed over."""
    made: T = _adapter(cast(Any, kind)).validate_python(document)
    return made


@lru_cache(None)
def _adapter(kind: Any) -> TypeAdapter[Any]:
    from pydantic import TypeAdapter

    return TypeAdapter(kind)


def plain(value: Any) -> Any:
    """Arrays as lists, dataclasses as objects, what is not finite as null."""
    if isinstance(value, float) or (hasattr(value, "dtype") and value.ndim == 0):
        value = value.item() if hasattr(value, "item") else value
        return value if not isinstance(value, float) or math.isfinite(value) else None
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    if isinstance(value, PurePath):
        return str(value)
    return value
