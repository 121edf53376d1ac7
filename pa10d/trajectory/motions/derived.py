"""A motion that is another one, changed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from pa10d.common.jsonable import JsonObject
from pa10d.trajectory.motions.base import Motion, motion_from_dict


@dataclass(frozen=True)
class Derived(Motion):
    """original: the other motion, as a file holds it."""

    original: JsonObject

    @cached_property
    def _inner(self) -> Motion:
        return motion_from_dict(self.original)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self._inner.n

    @property
    def duration(self) -> float:
        """s, the other one's."""
        return self._inner.duration

    @property
    def steady(self) -> tuple[float, float]:
        """The other one's."""
        return self._inner.steady
