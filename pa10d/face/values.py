"""What all values of the public face have in common: they compare by content and never change."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class ByContent(ABC):
    """Two values are equal where their ``content`` is."""

    @property
    @abstractmethod
    def content(self) -> Hashable:
        """Everything that makes the value what it is."""

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        assert isinstance(other, ByContent)
        return self.content == other.content

    def __hash__(self) -> int:
        return hash(self.content)


def frozen(values: ArrayLike) -> Array:
    """A copy as float64 that cannot be written to."""
    out = np.array(values, dtype=np.float64)
    out.flags.writeable = False
    return out


def bits(values: Array | None) -> Hashable:
    """An array's shape and bytes: NaN equals NaN, as in the same file read twice."""
    return None if values is None else (values.shape, values.tobytes())


def settled(document: Any) -> Hashable:
    """Lists, dicts and numbers of a JSON document as something that has a hash."""
    if isinstance(document, dict):
        return tuple((key, settled(value)) for key, value in sorted(document.items()))
    if isinstance(document, list | tuple):
        return tuple(settled(value) for value in document)
    return repr(document) if isinstance(document, float) else document


def listed(values: Array, digits: int = 3) -> str:
    """``0.123, 1.4, –`` for a person."""
    return ", ".join("–" if np.isnan(v) else f"{v:.{digits}g}" for v in values)
