"""What all values of the public face have in common: they compare by content and never change."""

from __future__ import annotations

import inspect
from abc import ABCMeta, abstractmethod
from collections.abc import Hashable, Iterator, Mapping
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
T = TypeVar("T")


class _Settling(ABCMeta):
    """Whose instances never change once they are made."""

    def __call__(cls, *given: Any, **named: Any) -> Any:
        made = super().__call__(*given, **named)
        vars(made)["_made"] = True
        return made

    @property
    def __signature__(cls) -> inspect.Signature:
        """What a call takes, for help: as ``__init__`` has it."""
        whole = inspect.signature(cls.__init__)  # type: ignore[misc]
        return whole.replace(parameters=list(whole.parameters.values())[1:])


class ByContent(metaclass=_Settling):
    """Two values are equal where their ``content`` is; nothing of them can be set."""

    def __setattr__(self, name: str, value: object) -> None:
        if "_made" in vars(self):
            raise AttributeError(f"{type(self).__name__}.{name}: a value never changes")
        super().__setattr__(name, value)

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{type(self).__name__}.{name}: a value never changes")

    @property
    @abstractmethod
    def content(self) -> Hashable:
        """Everything that makes the value what it is."""

    @abstractmethod
    def _page(self) -> str:
        """A page of HTML that shows it."""

    def _repr_html_(self) -> str:
        from pa10d.face.html import framed

        return framed(self._page())

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        assert isinstance(other, ByContent)
        return self.content == other.content

    def __hash__(self) -> int:
        return hash(self.content)


class Said:
    """A value that says itself in a line."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self}>"


class Fixed(Mapping[str, T]):
    """Names and values that never change; unlike a view of a dict it can go to other processes."""

    def __init__(self, content: Mapping[str, T]) -> None:
        self._content = dict(content)

    def __getitem__(self, name: str) -> T:
        return self._content[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._content)

    def __len__(self) -> int:
        return len(self._content)

    def __repr__(self) -> str:
        return repr(self._content)


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
