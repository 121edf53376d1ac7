"""One thing that a user should know of a recording before fitting a model to it."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Literal

from pa10d.common.jsonable import JsonObject

Severity = Literal["info", "warning", "error"]


@dataclass(frozen=True)
class Mend:
    """A field that is to be read in another unit: ``q{n}`` for all joints, ``q3`` for one.

    complete: False where its unit has words in it, such as RATIO, for what only the owner knows.
    source: the field whose column it is to be read from, in the unit that one is in; '': its own.
    """

    field: str
    unit: str
    complete: bool = True
    source: str = ""

    @property
    def option(self) -> str:
        """As ``--map`` takes it, with the names of this program for the file's columns."""
        if self.source:
            return f"{self.source}={self.field}"
        return f"'{self.field}[{self.unit}]={self.field.removesuffix('{n}')}'"


@dataclass(frozen=True)
class CheckFinding:
    """``error``: a fit would be wrong; ``warning``: it would be poorer; ``info``: good to know.

    mends: the options that the advice names, in its order.
    """

    severity: Severity
    code: str  # short and stable, for programs
    sentence: str
    advice: str = ""
    joint: int | None = None  # from 1
    mends: tuple[Mend, ...] = field(default=(), compare=False)

    def document(self) -> JsonObject:
        """As JSON knows it."""
        said = asdict(self)
        del said["mends"]
        return said

    def __str__(self) -> str:
        return f"{self.severity}: {self.sentence}" + (f" → {self.advice}" if self.advice else "")


def joint_label(j: int, names: tuple[str, ...] | None) -> str:
    """``joint 3 (S3)`` for index 2."""
    return f"joint {j + 1} ({names[j]})" if names else f"joint {j + 1}"


def percent(share: float) -> str:
    """A share of samples for a person: two digits, and never 1e+02."""
    value = 100 * share
    return f"{value:.0f} %" if value >= 10 else f"{value:.2g} %"
