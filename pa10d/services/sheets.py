"""Plots and words of an analysis, kept as JSON for whoever looks at it later."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.services.diagnoses import asked_of
from pa10d.services.library import Library
from pa10d.services.models import Compared
from pa10d.store.entries import own_folder
from pa10d.store.folders import write_text

if TYPE_CHECKING:
    from pa10d.report.sheet import Sheet


def write_comparison_sheet(compared: Compared, folder: Path) -> None:
    """``summary.json`` and ``joint-1.json`` … into the folder."""
    from pa10d.report.sheet import comparison_sheet

    _write(folder, comparison_sheet(compared.comparison, compared.staircase))


def write_diagnosis_sheet(
    library: Library,
    found: Diagnosis,
    folder: Path,
    model: str,
    fit: Sequence[str],
    validate: Sequence[str],
) -> None:
    """``summary.json`` into the folder."""
    from pa10d.figures.held_out import held_out
    from pa10d.report.sheet import diagnosis_sheet

    asked = asked_of(library, model, fit, validate)
    _write(folder, {"summary": diagnosis_sheet(found, held_out(found), asked)})


def _write(folder: Path, parts: Mapping[str, Sheet]) -> None:
    own_folder(folder)
    for name, part in parts.items():
        text = json.dumps(
            part.document(), ensure_ascii=False, allow_nan=False, separators=(",", ":")
        )
        write_text(folder / f"{name}.json", text)
