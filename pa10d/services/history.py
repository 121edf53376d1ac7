"""A model and all it was made from, judged alike: the same runs, one band, one mask."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.judgement import Judgement, common_band, judge_alike
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel
from pa10d.services.library import Library
from pa10d.store.models import ModelInfo


@dataclass(frozen=True)
class Version:
    """One model of the line; judgement: None where its runs are not in this store."""

    info: ModelInfo
    judgement: Judgement | None

    def document(self) -> JsonObject:
        """As JSON: the model's own entry with its error as judged here; ``fit``: what it was
        fitted to and the error there, in its own band."""
        info, judged = self.info, self.judgement
        fit = {"runs": list(info.runs), "cutoff_hz": info.cutoff_hz, "rms": list(info.rms)}
        entry = vars(info) | {"fit": fit, "mask": None, "noise_floor_from": None}
        return entry if judged is None else entry | judged.document()


def history(library: Library, model: str, runs: Sequence[str] = ()) -> list[Version]:
    """The first ancestor first. runs: to judge by; default: those that the model itself was judged
    by and had not seen, else those that it was fitted to."""
    infos = library.models.history(model)
    asked = list(runs) or _own_runs(library, infos[-1])
    try:
        found = list({i.id: i for i in map(library.runs.find, asked)}.values())
    except UserError:
        if runs:
            raise
        return [Version(info, None) for info in infos]
    recordings = [library.runs.recording(info) for info in found]
    judgements = judge_line(library, infos, recordings)
    return [Version(i, j) for i, j in zip(infos, judgements, strict=True)]


def judge_line(
    library: Library, infos: Sequence[ModelInfo], recordings: Sequence[Recording]
) -> list[Judgement]:
    """Every version of a line on the same runs."""
    line = [library.models.load(info) for info in infos]
    return judge_alike(line, recordings, beside=list(kin(library, infos).values()))


def kin(library: Library, infos: Sequence[ModelInfo]) -> dict[str, TorqueModel]:
    """All others that come from the same first model, by id: the noise of a run is seen through
    whichever of them shows it best. One that cannot be read any more shows nothing."""
    found, known = {}, {info.id for info in infos}
    for other in library.models.family(infos[-1]):
        if other.id not in known:
            with suppress(UserError):
                found[other.id] = library.models.load(other)
    return found


def line_band(library: Library, model: str) -> float:
    """Hz: the band that a model shares with all it was made from, so that errors compare."""
    return common_band(_line(library, model))


def _line(library: Library, model: str) -> list[TorqueModel]:
    return [library.models.load(info) for info in library.models.history(model)]


def _own_runs(library: Library, info: ModelInfo) -> list[str]:
    judged = library.models.load(info).notes.judged_on or ()
    return [run for run in judged if run not in info.runs] or list(info.runs)
