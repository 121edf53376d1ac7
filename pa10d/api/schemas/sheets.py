"""The plots and words of an analysis: a tree of blocks, each with its sort in ``block``."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from pa10d.api.schemas.plots import Figure


class TextBlock(BaseModel):
    """A paragraph."""

    block: Literal["text"]
    text: str
    muted: bool


class LinesBlock(BaseModel):
    """A ranked list."""

    block: Literal["lines"]
    items: list[tuple[str, str]] = Field(description="Tag and sentence of each")
    otherwise: str = Field(description="What to say where there are none")


class CardsBlock(BaseModel):
    """A few figures to be seen first."""

    block: Literal["cards"]
    items: list[tuple[str, str, str]] = Field(description="What, its value, and a remark")


class TableBlock(BaseModel):
    """Rows under a head; the first column is text, the others are numbers."""

    block: Literal["table"]
    head: list[str]
    rows: list[list[str]]
    words: int = Field(description="As many columns at the end are sentences")


class ReadingBlock(BaseModel):
    """How to read one kind of plot."""

    block: Literal["reading"]
    read: str
    then: str = Field(description="What to do next")
    noise: str = Field(description="How the noise is marked in it")


class PlotBlock(BaseModel):
    """One figure, or several to choose from by name."""

    block: Literal["plot"]
    title: str
    figures: Figure | dict[str, Figure]
    reading: ReadingBlock | None
    advice: str = Field(description="What these very data suggest")


class FactsBlock(BaseModel):
    """What a reader asks."""

    block: Literal["facts"]
    items: list[tuple[str, str]] = Field(description="Question and answer")


class VerdictBlock(BaseModel):
    """The sentence to be read first."""

    block: Literal["verdict"]
    sentence: str
    kind: str = Field(examples=["missing", "none", "unknown"])


class CommandBlock(BaseModel):
    """Commands to copy."""

    block: Literal["command"]
    says: str = Field(description="What they are for")
    lines: list[str]


class SectionBlock(BaseModel):
    """A heading with blocks under it."""

    block: Literal["section"]
    title: str
    blocks: list[AnyBlock]
    mark: str = Field(description="A few words beside the heading")
    folded: bool | None = Field(description="Closed until somebody opens it; null: never")
    listed: bool = Field(description="Whether it stands in the navigation")


AnyBlock = Annotated[
    CardsBlock | CommandBlock | FactsBlock | LinesBlock | PlotBlock | SectionBlock | TableBlock
    | TextBlock | VerdictBlock,
    Field(discriminator="block"),
]  # fmt: skip


class Sheet(BaseModel):
    """Plots and words of an analysis, as they were when its job ended."""

    sections: list[SectionBlock]
    findings: list[SectionBlock] | None = Field(None, description="Of a diagnosis, best first")
    unexplained: list[SectionBlock] | None = Field(
        None, description="Of a diagnosis: what no effect explains, as its result lists it"
    )
