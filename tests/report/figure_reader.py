"""Reads figures as Plotly does."""

from __future__ import annotations

import base64
import json
from html.parser import HTMLParser
from typing import Any

import numpy as np


def numbers(value: Any) -> np.ndarray:
    """A list, or what is packed in base64."""
    if isinstance(value, dict):
        kind = {"f4": "<f4", "f8": "<f8"}[value["dtype"]]
        return np.frombuffer(base64.b64decode(value["bdata"]), dtype=kind).astype(float)
    return np.array(value)


class Report(HTMLParser):
    """What stands in an HTML report."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.links: list[str] = []
        self.attributes: set[str] = set()
        self.ids: list[str] = []
        self.canvases: list[str] = []
        self.scripts: list[str] = []
        self.stored: dict[str, str] = {}
        self.words: list[str] = []
        self.open: list[str] = []
        self._in: tuple[str, dict] = ("", {})
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self._in = (tag, given)
        self.attributes |= set(given)
        self.links += [given[k] for k in ("src", "href") if given.get(k)]
        if "id" in given:
            self.ids.append(given["id"])
        if "data-figure" in given:
            self.canvases.append(given["data-figure"])
        if tag not in ("meta", "link", "br", "img", "input"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        self._in = ("", {})

    def handle_data(self, data):
        tag, given = self._in
        if tag == "script" and given.get("type") == "application/json":
            self.stored[given["id"]] = data
        elif tag == "script":
            self.scripts.append(data)
        elif tag != "style":
            self.words.append(data)

    def figure(self, key: str) -> dict:
        return json.loads(self.stored[key])
