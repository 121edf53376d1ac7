"""A report's content as plain numbers and words: the web page draws the same blocks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
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

BLOCKS: dict[str, type] = {
    "cards": Cards, "command": Command, "facts": Facts, "lines": Lines, "plot": Plot,
    "reading": Reading, "section": Section, "table": Table, "text": Text, "verdict": Verdict,
}  # fmt: skip
"""As the page calls them, whatever their classes are called."""
NAMES = {block: name for name, block in BLOCKS.items()}


@dataclass(frozen=True)
class Sheet:
    """Sections in their order; of a diagnosis also what was found and what no effect explains, one
    section each, which the page shows apart."""

    sections: tuple[Section, ...]
    findings: tuple[Section, ...] | None = None
    unexplained: tuple[Section, ...] | None = None

    def document(self) -> JsonObject:
        """As JSON: every block says its sort in ``block``."""
        parts = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: _plain(part) for name, part in parts.items() if part is not None}

    @classmethod
    def read(cls, document: Any) -> Sheet:
        """The reverse, figures as they stand. Further fields of another version's blocks are passed
        over; UserError where it is no sheet."""
        if not isinstance(document, Mapping) or "sections" not in document:
            raise UserError("no 'sections'; expected the plots and words of an analysis")
        named = (field.name for field in fields(cls))
        return cls(**{key: _sections(key, document[key]) for key in named if key in document})

    @property
    def in_order(self) -> tuple[Section, ...]:
        """All of it as a report has it: what was found stands behind the verdict."""
        verdict, rest = self.sections[:1], self.sections[1:]
        return (*verdict, *(self.findings or ()), *(self.unexplained or ()), *rest)


def comparison_sheet(comparison: Comparison, steps: Sequence[Stair] = ()) -> dict[str, Sheet]:
    """``summary``, and ``joint-1`` … ``joint-n`` apart, so that a page loads what it shows."""
    out = {"summary": Sheet(tuple(summary_sections(comparison, steps)))}
    for j in range(comparison.model.robot.n):
        out[f"joint-{j + 1}"] = Sheet((joint_section(comparison, j, over_time=False),))
    return out


def diagnosis_sheet(found: Diagnosis, seen: HeldOut, asked: Asked) -> Sheet:
    """The verdict first."""
    parts = diagnosis_sections(found, seen, asked)
    return Sheet((parts.verdict, *parts.rest), tuple(parts.findings), tuple(parts.unexplained))


def without_commands(section: Section) -> Section:
    """The same without what to type next, which a report of work that is done leaves out."""
    kept = [b for b in section.blocks if not isinstance(b, Command)]
    inner = [without_commands(b) if isinstance(b, Section) else b for b in kept]
    return replace(section, blocks=inner)


def _sections(name: str, found: Any) -> tuple[Section, ...]:
    read = _block(found)
    if not isinstance(read, list) or not all(isinstance(one, Section) for one in read):
        raise UserError(f"{name}: found no list of sections")
    return tuple(read)


def _block(plain: Any) -> Any:
    """A block and all in it."""
    if isinstance(plain, list):
        return [_block(item) for item in plain]
    if not isinstance(plain, Mapping) or "block" not in plain:
        return plain
    name = plain["block"]
    if not isinstance(name, str) or name not in BLOCKS:
        raise UserError(f"block: found {name!r}, expected one of {', '.join(BLOCKS)}")
    own = fields(BLOCKS[name])
    lacking = [f.name for f in own if f.name not in plain and f.default is MISSING]
    if lacking:
        raise UserError(f"block {name}: no {', '.join(lacking)}")
    return BLOCKS[name](**{f.name: _block(plain[f.name]) for f in own if f.name in plain})


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
