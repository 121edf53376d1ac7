"""What requests and lists of every kind have in common."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Name = Annotated[str, Field(min_length=1, max_length=100, examples=["monday-cold"])]


class Strict(BaseModel):
    """A request: unknown keys are refused."""

    model_config = ConfigDict(extra="forbid")


class Page(BaseModel):
    """Part of a list; ``next`` goes on where this one ends."""

    total: int
    next: str | None = Field(None, description="Give it as 'cursor' to go on")


class SetAside(BaseModel):
    """Something in the data folder that cannot be used; it is left as it is."""

    id: str
    name: str = Field(description="As far as it can be made out")
    place: str = Field(description="In the data folder", examples=["models/m0.yaml"])
    reason: str


Runs = Annotated[list[Name], Field(min_length=1, max_length=100)]

Force = Annotated[bool, Field(description="Also runs that the checks have an error against")]
