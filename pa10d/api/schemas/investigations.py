"""Investigations, a step at a time."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from pa10d.api.schemas.common import Force, Name, Page, SetAside, Strict
from pa10d.services.documents import Step


class InvestigationRequest(Strict):
    """An investigation: its motions are planned and shown; nothing moves before it is carried
    out. With ``fit`` nothing ever moves."""

    name: Name | None = None
    minutes: float | None = Field(
        None, gt=0, le=1440, description="Of motion; what does not fit is left out (default: 15)"
    )
    since: Name | None = Field(None, description="A model: what has changed since then?")
    fit: Annotated[list[Name], Field(max_length=100)] = []
    validate_: Annotated[list[Name], Field(max_length=100, alias="validate")] = []
    force: Force = False

    @property
    def names_no_recordings(self) -> bool:
        """Whether somebody speaks of recordings and gives none to fit to: taken as it stands, that
        would move the arm of who wanted it not to move."""
        return not self.fit and not {"fit", "validate_"}.isdisjoint(self.model_fields_set)


class StartRequest(Strict):
    """How an investigation moves the arm."""

    recover: bool = Field(
        False,
        description="Bring an arm back inside that stands outside its position limits, before a "
        "motion or after one that led there",
    )


class InvestigationDocument(BaseModel):
    """How far it is; further fields as ``pa10d schema investigate`` has them."""

    model_config = ConfigDict(extra="allow")
    id: str
    name: str
    status: Literal["waiting", "running", "paused", "stopped", "failed", "done"]
    question: Literal["missing", "changed"]
    moves: bool
    steps: list[Step]


class InvestigationBrief(BaseModel):
    """One of a list."""

    id: str
    name: str
    robot: str
    status: str
    question: str
    moves: bool
    created: str


class InvestigationPage(Page):
    """Investigations, newest first."""

    items: list[InvestigationBrief]
    set_aside: list[SetAside] = Field(description="Folders that hold none, and why")
