"""A report inside a notebook: whole and apart, so that neither disturbs the other's style."""

from __future__ import annotations

import html

HEIGHT = 640  # px


def framed(page: str) -> str:
    """The page as a frame of its own; nothing is loaded from elsewhere."""
    text = html.escape(page, quote=True)
    style = f"width:100%;height:{HEIGHT}px;border:0"
    return f'<iframe title="pa10d report" style="{style}" srcdoc="{text}"></iframe>'
