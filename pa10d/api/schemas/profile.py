"""Changes of the profile."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from pa10d.api.schemas.common import Strict
from pa10d.common.jsonable import JsonObject
from pa10d.services.tuning.keys import TuningKey

StatedValue = Annotated[float, Field(strict=True)] | str | list[Any] | JsonObject | None


class ProfileUndo(Strict):
    """Take the last change back."""

    confirmed: bool = Field(False, description="What 'confirm' says was read")


class ProfileChanges(Strict):
    """What shall be changed. A value, null for none, or for some joints {"2": value}."""

    changes: dict[TuningKey, StatedValue] = Field(
        min_length=1, examples=[{"control.bandwidth_hz": 3.0, "limits.velocity": {"2": 0.8}}]
    )
    confirmed: bool = Field(False, description="What 'confirm' says was read")
