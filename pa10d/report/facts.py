"""Two more blocks: questions with their answers, and commands to copy."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass

from pa10d.report.blocks import Numbers


@dataclass(frozen=True)
class Facts:
    """What a reader asks, and the answer beside it."""

    items: Sequence[tuple[str, str]]

    def render(self, number: Numbers) -> str:
        """As HTML."""
        rows = "".join(
            f"<dt>{html.escape(asked)}</dt><dd>{html.escape(answer)}</dd>"
            for asked, answer in self.items
            if answer
        )
        return f'<dl class="facts">{rows}</dl>'


@dataclass(frozen=True)
class Verdict:
    """The sentence to be read first; kind: ``missing``, ``none`` or ``unknown``."""

    sentence: str
    kind: str

    def render(self, number: Numbers) -> str:
        """As HTML."""
        return f'<p class="verdict {html.escape(self.kind)}">{html.escape(self.sentence)}</p>'


@dataclass(frozen=True)
class Command:
    """Commands to copy, with a line that says what they are for."""

    says: str
    lines: Sequence[str]

    def render(self, number: Numbers) -> str:
        """As HTML."""
        text = html.escape("\n".join(self.lines))
        return f'<p class="muted">{html.escape(self.says)}</p><pre class="command">{text}</pre>'
