"""What the steps of an investigation compute: each takes a state and gives what came of it.

Every step can be carried out again: what it stores has names of the investigation's own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from pa10d.common.errors import UserError
from pa10d.common.jsonable import parsed, plain
from pa10d.common.words import listed
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.diagnose.outcome.words import in_json
from pa10d.diagnose.search.delivery import delivered
from pa10d.dynamics import Robot
from pa10d.identify.summary import summary
from pa10d.investigation.archive import SHEET, Archive
from pa10d.investigation.doubts import write_doubts
from pa10d.investigation.results import LastWord, Searched, StepOutcome, StoredAs
from pa10d.investigation.state import Investigation, Step
from pa10d.investigation.words import (
    added_words,
    compared_words,
    fall_words,
    fit_notes,
    found_words,
    identified_words,
    judged_where,
    left_words,
)
from pa10d.judgement import Judgement
from pa10d.services.diagnoses import diagnose_runs
from pa10d.services.history import history
from pa10d.services.library import Library, open_library
from pa10d.services.models import compare_runs, identify_runs
from pa10d.services.sheets import write_diagnosis_sheet
from pa10d.store.entries import own_folder
from pa10d.store.folders import write_text
from pa10d.store.model_parse import read_model
from pa10d.store.model_text import model_text
from pa10d.store.models import new_info

Progress = Callable[[float, str], None]
VERSIONS = "versions"
MUCH = 2.0  # times its noise: what a joint keeps is said


def compute(data: str, investigation: str, step: str, progress: Progress) -> StepOutcome:
    """Carry out a step that needs no motion."""
    archive = Archive(data)
    state = archive.load(investigation)
    wanted = state.step(step)
    work = WORK[wanted.kind]
    outcome = work(open_library(data), archive.place(investigation), state, wanted, progress)
    return replace(outcome, result=plain(outcome.result))


def _identify(
    library: Library, place: Path, state: Investigation, step: Step, progress: Progress
) -> StepOutcome:
    made = identify_runs(
        library, state.to_fit, state.profile, name=_name(state, 0), replace=True,
        force=state.force, progress=progress,
    )  # fmt: skip
    fit = summary(made.model)
    return StepOutcome(
        models=[made.info.id], result=made.summary, said=identified_words(fit), notes=fit_notes(fit)
    )


def _compare(
    library: Library, place: Path, state: Investigation, step: Step, progress: Progress
) -> StepOutcome:
    runs = state.unseen or state.to_fit
    found = compare_runs(library, _base(state), runs, force=state.force, progress=progress)
    kept = {"runs": [run.id for run in found.runs], "pooled": found.document()["pooled"]}
    said = compared_words(found.comparison.pooled, found.info.name)
    if not state.unseen:
        said = f"Judged on the runs it was fitted to: there are no others. {said}"
    there, mask = listed([run.name for run in found.runs]), found.comparison.pooled.mask
    on = judged_where(there, found.comparison.model.cutoff, mask)
    said = f"{said} Judged on {on}."
    return StepOutcome(result=kept, said=said)


def _diagnose(
    library: Library, place: Path, state: Investigation, step: Step, progress: Progress
) -> StepOutcome:
    fit, judge, base = state.to_fit, state.to_judge, _base(state)
    frozen = state.question == "changed"
    found = diagnose_runs(
        library, base, fit, judge, frozen=frozen, force=state.force, progress=progress
    )
    progress(0.97, "plots")
    write_diagnosis_sheet(library, found, place / SHEET, base, fit, judge)
    _keep_versions(found, place / VERSIONS)
    document = plain(in_json(found))
    seen = parsed(Searched, document)
    ways = write_doubts(state.profile, seen.findings, place)
    for finding, way in zip(document["findings"], ways, strict=True):
        if way is not None:
            finding["settling"] = plain(way)
    return StepOutcome(result=document, said=found_words(found))


def _add(
    library: Library, place: Path, state: Investigation, step: Step, progress: Progress
) -> StepOutcome:
    """Exactly what the search judged is stored."""
    parent = library.models.find(_base(state)).name
    infos, models = [], []
    for number in range(1, len(state.findings) + 1):
        progress(number / (len(state.findings) + 1), "storing")
        kept = read_model(place / VERSIONS / f"{number}.yaml")[0]
        model = replace(kept, name=_name(state, number), parent=parent)
        infos.append(library.models.save(model, replace=True))
        models.append(model)
        parent = model.name
    stored = [StoredAs(info.id, info.name, info.change) for info in infos]
    result = {"versions": plain(stored), **vars(delivered(models[-1]))}
    said = added_words(stored, state.findings, state.question == "changed")
    return StepOutcome(models=[info.id for info in infos], result=result, said=said)


def _judge(
    library: Library, place: Path, state: Investigation, step: Step, progress: Progress
) -> StepOutcome:
    """The first and the last version, on the same runs in one band."""
    fresh = state.recorded("fresh")
    runs = fresh or state.unseen or state.to_fit
    line = history(library, state.versions[-1], runs)
    judged = [version for version in line if version.info.id in state.versions]
    first, last = judged[0].judgement, judged[-1].judgement
    if first is None or last is None:
        raise UserError(f"runs {', '.join(runs)}: not in the store any more")
    robot = library.models.load(judged[-1].info).robot
    word = LastWord(
        fresh=bool(fresh),
        seen="no fit has seen" if fresh or state.unseen else "the models were fitted to",
        runs=runs,
        models=[version.info.name for version in judged],
        before=plain(first.rms),
        after=plain(last.rms),
        noise_floor=plain(last.floor.values),
        cutoff_hz=last.cutoff,
        mask=last.mask,
        units=[robot.torque_unit(j) for j in range(robot.n)],
        run_names=[library.runs.find(run).name for run in runs],
        left=_left(library, state, runs, last, robot),
        hidden=[j + 1 for j in last.hidden],
    )
    return StepOutcome(result=plain(word), said=fall_words(word))


def _left(
    library: Library, state: Investigation, runs: list[str], last: Judgement, robot: Robot
) -> list[str]:
    ratio = last.rms / last.floor.values
    much = np.flatnonzero(ratio > MUCH)
    if not much.size:
        return []
    found = compare_runs(library, state.versions[-1], runs, force=state.force)
    return left_words({int(j): last.rms[j] for j in much}, ratio, found.comparison.pooled, robot)


def _report(
    library: Library, place: Path, state: Investigation, step: Step, progress: Progress
) -> StepOutcome:
    from pa10d.investigation.report import write_report

    path = write_report(library, place, state)
    return StepOutcome(result={"report": str(path)}, said="The report is written.")


WORK: Mapping[str, Callable[[Library, Path, Investigation, Step, Progress], StepOutcome]] = {
    "identify": _identify,
    "compare": _compare,
    "diagnose": _diagnose,
    "add": _add,
    "judge": _judge,
    "report": _report,
}


def _keep_versions(found: Diagnosis, folder: Path) -> None:
    """What the search judged, as model files, until it is added."""
    for old in own_folder(folder).glob("*.yaml"):
        old.unlink()
    for number, version in enumerate(found.stored, 1):
        write_text(folder / f"{number}.yaml", model_text(version, new_info(version, None)))


def _base(state: Investigation) -> str:
    if state.base is None:
        raise UserError(f"{state.name}: no model was fitted yet")
    return state.base


def _name(state: Investigation, number: int) -> str:
    """Of a model: the investigation's own, so that it can be made again."""
    return f"{state.name}-m{number}"
