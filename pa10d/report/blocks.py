"""What reports are built of; each block turns itself into HTML."""

from __future__ import annotations

import html
import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from pa10d.figures.plotly import Figure
from pa10d.figures.texts import Reading


class Numbers:
    """Hands out element ids within one page."""

    def __init__(self) -> None:
        self._count = itertools.count(1)

    def __call__(self, stem: str) -> str:
        return f"{stem}-{next(self._count)}"


class Block(Protocol):
    """Anything that stands in a report."""

    def render(self, number: Numbers) -> str: ...


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    text: str
    muted: bool = False

    def render(self, number: Numbers) -> str:
        """As HTML."""
        kind = ' class="muted"' if self.muted else ""
        return f"<p{kind}>{html.escape(self.text)}</p>"


@dataclass(frozen=True)
class Lines:
    """A ranked list of sentences, with a tag before each where there is one."""

    items: Sequence[tuple[str, str]]  # (tag, sentence)
    otherwise: str = ""

    def render(self, number: Numbers) -> str:
        """As HTML."""
        if not self.items:
            return f"<p>{html.escape(self.otherwise)}</p>"
        rows = "".join(
            f"<li>{f'<b>{html.escape(tag)}</b> ' if tag else ''}{html.escape(sentence)}</li>"
            for tag, sentence in self.items
        )
        return f'<ol class="ranked">{rows}</ol>'


@dataclass(frozen=True)
class Cards:
    """A few figures to be seen first: (what, value, remark)."""

    items: Sequence[tuple[str, str, str]]

    def render(self, number: Numbers) -> str:
        """As HTML."""
        cards = "".join(
            f'<div class="card"><span>{html.escape(what)}</span>'
            f"<strong>{html.escape(value)}</strong><small>{html.escape(remark)}</small></div>"
            for what, value, remark in self.items
        )
        return f'<div class="cards">{cards}</div>'


@dataclass(frozen=True)
class Table:
    """Rows under a head; the first column is text, the others are numbers, but for the last
    ``words`` ones, whose sentences break where there is no room."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: int = 0

    def render(self, number: Numbers) -> str:
        """As HTML."""
        head = self._row("th", self.head)
        body = "".join(self._row("td", row) for row in self.rows)
        return (
            f'<div class="scroll"><table><thead>{head}</thead><tbody>{body}</tbody></table></div>'
        )

    def _row(self, kind: str, cells: Sequence[str]) -> str:
        numbers = len(cells) - self.words
        marks = ["" if k < numbers else ' class="text"' for k in range(len(cells))]
        inner = (
            f"<{kind}{mark}>{html.escape(cell)}</{kind}>"
            for mark, cell in zip(marks, cells, strict=True)
        )
        return f"<tr>{''.join(inner)}</tr>"


@dataclass(frozen=True)
class Plot:
    """One figure, or several to choose from by name; drawn when it comes into view."""

    title: str
    figures: Figure | Mapping[str, Figure]
    reading: Reading | None = None
    advice: str = ""  # what these very data suggest, before the general words

    def render(self, number: Numbers) -> str:
        """As HTML."""
        named = {"": self.figures} if "data" in self.figures else dict(self.figures)
        ids = {name: number("figure") for name in named}
        height = max(int(figure["layout"].get("height", 300)) for figure in named.values())
        stored = "".join(
            f'<script type="application/json" id="{ids[name]}">{embedded(figure)}</script>'
            for name, figure in named.items()
        )
        first = next(iter(ids.values()))
        choice = _choice(ids) if len(ids) > 1 else ""
        return (
            f'<figure class="plot"><figcaption>{html.escape(self.title)}{choice}</figcaption>'
            f'<div class="canvas" data-figure="{first}" style="height:{height / 16:g}rem"></div>'
            f"{stored}{self._words()}</figure>"
        )

    def _words(self) -> str:
        if self.reading is None:
            return f'<p class="advice">{html.escape(self.advice)}</p>' if self.advice else ""
        advice = f"<b>{html.escape(self.advice)}</b> " if self.advice else ""
        return (
            '<div class="words">'
            f"<p><span>How to read this</span>{html.escape(self.reading.read)}</p>"
            f"<p><span>What to do next</span>{advice}{html.escape(self.reading.then)}</p></div>"
        )


@dataclass(frozen=True)
class Section:
    """A heading with blocks under it; ``folded``: closed until somebody opens it; ``mark``: a few
    words beside the heading; ``listed``: in the navigation."""

    title: str
    blocks: Sequence[Block]
    mark: str = ""
    folded: bool | None = None
    listed: bool = True

    def render(self, number: Numbers) -> str:
        """As HTML."""
        inner = "".join(block.render(number) for block in self.blocks)
        name = html.escape(self.title)
        mark = f"<small>{html.escape(self.mark)}</small>" if self.mark else ""
        content = f"<h2>{name}{mark}</h2>"
        if self.folded is None:
            content += inner
        else:
            state = "" if self.folded else " open"
            content = f"<details{state}><summary>{content}</summary>{inner}</details>"
        title = f' data-title="{name}"' if self.listed else ' class="inner"'
        return f'<section id="{number("section")}"{title}>{content}</section>'


def embedded(document: Any) -> str:
    """JSON that cannot end the script element it stands in."""
    text = json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def _choice(ids: Mapping[str, str]) -> str:
    options = "".join(
        f'<option value="{key}">{html.escape(name)}</option>' for name, key in ids.items()
    )
    return f'<select aria-label="choose">{options}</select>'
