"""A whole page in one file: styles, plotly.js and data are inside, nothing is loaded."""

from __future__ import annotations

import html
from collections.abc import Sequence
from functools import cache
from importlib.resources import files

from pa10d.report.blocks import Block, Numbers

DRAWN = 'data-figure="'
"""Where a plot stands; a page without one does not carry what draws it."""

TEMPLATE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
<header><h1>{title}</h1><p>{subtitle}</p></header>
<nav aria-label="sections"></nav>
<main>{body}</main>
<footer>{footer}</footer>
<script>{plotly}</script>
<script>{plots}</script>
<script>{behaviour}</script>
</body>
</html>
"""


def page(title: str, subtitle: str, blocks: Sequence[Block], footer: str) -> str:
    """The HTML text."""
    number = Numbers()
    body = "\n".join(block.render(number) for block in blocks)
    return TEMPLATE.format(
        title=html.escape(title),
        subtitle=html.escape(subtitle),
        footer=html.escape(footer),
        body=body,
        style=_asset("pa10d.report", "style.css"),
        plotly=plotly_js() if DRAWN in body else "",
        plots=_asset("pa10d.figures", "plots.js"),
        behaviour=_asset("pa10d.report", "page.js"),
    )


@cache
def plotly_js() -> str:
    """The library, safe inside a script element."""
    return _asset("pa10d.figures", "vendor/plotly.js").replace("</script", "<\\/script")


@cache
def _asset(package: str, name: str) -> str:
    return (files(package) / name).read_text(encoding="utf-8")
