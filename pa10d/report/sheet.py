"""A report's content as plain numbers and words: the web page draws the same blocks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from pa10d.common.jsonable import JsonObject
from pa10d.compare import Comparison
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.figures.held_out import HeldOut
from pa10d.figures.staircase import Stair
from pa10d.figures.texts import Reading
from pa10d.report.blocks import Cards, Lines, Plot, Section, Table, Text
from pa10d.report.compare_page import joint_section, summary_sections
from pa10d.report.diagnosis_page import diagnosis_sections
from pa10d.report.facts import Command, Facts, Verdict
from pa10d.report.finding_section import Asked

Sheet = JsonObject
BLOCKS: dict[str, type] = {
    "cards": Cards, "command": Command, "facts": Facts, "lines": Lines, "plot": Plot,
    "reading": Reading, "section": Section, "table": Table, "text": Text, "verdict": Verdict,
}  # fmt: skip
"""As the page calls them, whatever their classes are called."""
NAMES = {block: name for name, block in BLOCKS.items()}


def comparison_sheet(comparison: Comparison, steps: Sequence[Stair] = ()) -> dict[str, Sheet]:
    """``summary``, and ``joint-1`` … ``joint-n`` apart, so that a page loads what it shows."""
    summary = [_plain(section) for section in summary_sections(comparison, steps)]
    out: dict[str, Sheet] = {"summary": {"sections": summary}}
    for j in range(comparison.model.robot.n):
        section = joint_section(comparison, j, over_time=False)
        out[f"joint-{j + 1}"] = {"sections": [_plain(section)]}
    return out


def diagnosis_sheet(found: Diagnosis, seen: HeldOut, asked: Asked) -> dict[str, Sheet]:
    """``summary`` with ``sections`` (the verdict first), and ``findings`` and ``unexplained``, one
    section each."""
    parts = diagnosis_sections(found, seen, asked)
    sections = [_plain(section) for section in (parts.verdict, *parts.rest)]
    apart = {"findings": _plain(parts.findings), "unexplained": _plain(parts.unexplained)}
    return {"summary": {"sections": sections, **apart}}


def sections_of(sheet: Sheet, *, commands: bool = True) -> list[Section]:
    """A sheet as blocks again, for a report of whoever has it by HTTP: findings come second.
    commands: with what to type next, which a report of work that is done leaves out."""
    verdict, *rest = sheet["sections"]
    apart = (*sheet.get("findings", ()), *sheet.get("unexplained", ()))
    parts = [verdict, *apart, *rest]
    return [_block(part) for part in (parts if commands else _without(parts, "command"))]


def _without(plain: Any, name: str) -> Any:
    """The same without the blocks of this name."""
    if isinstance(plain, list):
        return [
            _without(i, name) for i in plain if not (isinstance(i, dict) and i.get("block") == name)
        ]
    if isinstance(plain, dict) and plain.get("block") == "section":
        return plain | {"blocks": _without(plain["blocks"], name)}
    return plain


def _block(plain: Any) -> Any:
    """The reverse of ``_plain``; figures stay as they are."""
    if isinstance(plain, list):
        return [_block(item) for item in plain]
    if not isinstance(plain, dict) or "block" not in plain:
        return plain
    own = {key: _block(item) for key, item in plain.items() if key != "block"}
    return BLOCKS[plain["block"]](**own)


def _plain(value: Any) -> Any:
    """Blocks as ``{"block": "plot", …}``; everything else as JSON knows it."""
    if is_dataclass(value) and not isinstance(value, type):
        plain = {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
        return {"block": NAMES[type(value)], **plain}
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value
