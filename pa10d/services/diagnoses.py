"""Diagnoses of stored models on stored runs; adding effects; improving until nothing is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.diagnose.asked.adding import add_asked, refuse_slips
from pa10d.diagnose.asked.changed import what_changed
from pa10d.diagnose.asked.smooth import add_map
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.diagnose.outcome.words import in_json
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.search.suspects import suspicion
from pa10d.effects import all_effects
from pa10d.judgement import worse_elsewhere
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel
from pa10d.services.library import Library
from pa10d.services.memory import refuse_beyond_memory
from pa10d.services.models import read_runs, write_file
from pa10d.services.soundness import read_wrong
from pa10d.store.models import ModelInfo

if TYPE_CHECKING:
    from pa10d.report.blocks import Block
    from pa10d.report.finding_section import Asked

Progress = Callable[[float, str], None]
Cancel = Callable[[], bool]


@dataclass(frozen=True)
class Improved:
    """The stored versions, the given model's successor first, and the diagnosis behind them.

    doubt: the experiment that should be run first; then nothing was stored
    maps: versions with smooth maps over what the diagnosis could not explain, after its own
    elsewhere: what is worse on the runs that the given model was fitted to, in words
    """

    infos: tuple[ModelInfo, ...]
    diagnosis: Diagnosis
    doubt: NextExperiment | None = None
    maps: tuple[TorqueModel, ...] = ()
    elsewhere: tuple[str, ...] = ()

    @property
    def models(self) -> tuple[TorqueModel, ...]:
        """As they were stored, one for each of ``infos``."""
        return (*self.diagnosis.stored, *self.maps)

    def document(self) -> JsonObject:
        """As JSON: the diagnosis, and which models were stored."""
        made = [
            {"id": i.id, "name": i.name, "change": i.change, "held_out": list(map(float, held_out))}
            for i, m in zip(self.infos, self.models, strict=False)
            for held_out in [m.held_out["held out"]]
        ]
        last = self.infos[-1] if self.infos else None
        return {
            "id": last.id if last else None,
            "name": last.name if last else None,
            "versions": made,
            "doubt": self.doubt and self.doubt.document(),
            **in_json(self.diagnosis),
            "warnings": list(self.warnings),
        }

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is to be known of the versions."""
        return (*self.diagnosis.warnings, *self.elsewhere)


def diagnose_runs(
    library: Library,
    model: str,
    fit: Sequence[str],
    validate: Sequence[str] = (),
    *,
    frozen: bool = False,
    effect: str | None = None,
    joints: Sequence[int] = (),
    force: bool = False,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Diagnosis:
    """Diagnose a stored model on stored runs. joints: numbered from 1; force: also on runs that
    the checks have an error against."""
    if joints and effect is None:
        raise UserError("--joint: given without --effect; expected the effect to test there")
    loaded = library.models.load(library.models.find(model))
    only = None if effect is None else (effect, [j - 1 for j in joints])
    if only is not None:
        suspicion(only, loaded.robot.n)  # a slip of the pen is said before anything is read
    refuse_beyond_memory("diagnose", [library.runs.find(run) for run in (*fit, *validate)])
    infos, fitted = read_runs(library, fit, loaded.robot, force=force)
    others, judged = (
        read_runs(library, validate, loaded.robot, force=force) if validate else ([], [])
    )
    if frozen and only is None:
        own = _own_runs(library, loaded, [run.name for run in (*fitted, *judged)])
        found = what_changed(loaded, fitted, judged, own, progress=progress, cancel=cancel)
    else:
        found = diagnose(
            loaded, fitted, judged, frozen=frozen, only=only, progress=progress, cancel=cancel
        )
    return replace(found, read_wrong=read_wrong({i.id: i for i in [*infos, *others]}.values()))


def _own_runs(library: Library, model: TorqueModel, asked: Sequence[str]) -> list[Recording]:
    """The runs that a model was identified from, as far as they are still there, and none that is
    asked about, or all would not fit into memory."""
    names = [info.name for info in library.runs.all() if info.name in model.runs]
    names = [name for name in names if name not in asked]
    try:
        refuse_beyond_memory("diagnose", [library.runs.find(name) for name in names])
        return read_runs(library, names, model.robot, force=True)[1] if names else []
    except UserError:
        return []


def add_effect(
    library: Library,
    model: str,
    effect: str,
    joints: Sequence[int],
    fit: Sequence[str],
    *,
    name: str,
    over: Sequence[str] = (),
    replace_model: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> tuple[ModelInfo, TorqueModel, list[str]]:
    """Store a new version with an effect fitted in; the old one stays.

    over: quantities of a smooth map; see ``pa10d.diagnose.asked.adding``.
    """
    if not replace_model:
        library.models.refuse_taken(name)
    loaded = library.models.load(library.models.find(model))
    at = [j - 1 for j in joints]
    refuse_slips(loaded, effect, at, over)  # before anything is read
    refuse_beyond_memory("diagnose", [library.runs.find(run) for run in fit])
    runs = read_runs(library, fit, loaded.robot, force=force)[1]
    made, warnings = add_asked(loaded, effect, at, runs, name=name, over=over, progress=progress)
    kind = all_effects().get(effect)
    if kind is None or kind.question != "changed":  # what has changed since is not in older runs
        warnings += _worse_elsewhere(library, loaded, made, fit)
    return library.models.save(made, replace=replace_model), made, warnings


def improve_model(
    library: Library,
    model: str,
    fit: Sequence[str],
    validate: Sequence[str] = (),
    *,
    name: str,
    replace_model: bool = False,
    tried: Sequence[NextExperiment] | None = None,
    smooth: bool = False,
    force: bool = False,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Improved:
    """Diagnose and add until nothing significant is left; every step is a stored version.

    The last version has the given name, the ones before it NAME.1, NAME.2 …
    tried: what was run to settle doubts; where the diagnosis asks for anything else, nothing is
    stored. None: doubts are left as they are.
    smooth: what no effect explains is taken away by smooth maps.
    """
    if not replace_model:
        library.models.refuse_taken(name)
    found = diagnose_runs(
        library, model, fit, validate, force=force, progress=progress, cancel=cancel
    )
    if tried is not None:
        asked = [one.next_experiment for one in found.findings if one.next_experiment is not None]
        new = next((one for one in asked if one not in tried), None)
        if new is not None:
            return Improved((), found, new)
    given = library.models.load(library.models.find(model))  # before its name is another's
    maps = _maps_over_unexplained(library, found, fit, validate) if smooth else ()
    infos = store_versions(
        library, model, found, name=name, replace_model=replace_model, further=maps
    )
    made = Improved(infos, found, maps=maps)
    if not infos:
        return made
    told = _worse_elsewhere(library, given, made.models[-1], (*fit, *validate))
    return replace(made, elsewhere=tuple(told))


def _worse_elsewhere(
    library: Library, given: TorqueModel, made: TorqueModel, asked: Sequence[str]
) -> list[str]:
    """What a new version does worse on the given model's own runs, where it was not fitted to
    them."""
    own = _own_runs(library, given, [library.runs.find(run).name for run in asked])
    return worse_elsewhere(given, made, own) if own else []


def _maps_over_unexplained(
    library: Library, found: Diagnosis, fit: Sequence[str], validate: Sequence[str]
) -> tuple[TorqueModel, ...]:
    """One version after the other, each with one more map; those that do not help are left out."""
    robot = found.model.robot  # the diagnosis has let these runs pass
    runs = read_runs(library, fit, robot, force=True)[1]
    judged = read_runs(library, validate, robot, force=True)[1] if validate else ()
    versions = [found.kept]
    for structure in found.mapped:
        made = add_map(
            versions[-1], [structure.joint], structure.variables, runs,
            name=versions[-1].name, validate=judged,
        )  # fmt: skip
        if made.helps:
            versions.append(made.model)
    return tuple(versions[1:])


def store_versions(
    library: Library,
    model: str,
    found: Diagnosis,
    *,
    name: str,
    replace_model: bool = False,
    further: Sequence[TorqueModel] = (),
) -> tuple[ModelInfo, ...]:
    """Every step of a diagnosis, and ``further`` ones, as a stored version, each the parent of the
    next; the last one has the given name, the ones before it NAME.1, NAME.2 …"""
    parent = library.models.find(model).name
    steps = [*found.stored, *further]
    infos = []
    for number, version in enumerate(steps, 1):
        own = name if number == len(steps) else f"{name}.{number}"
        version = replace(version, name=own, parent=parent)
        infos.append(library.models.save(version, replace=replace_model))
        parent = own
    return tuple(infos)


def write_diagnosis_report(
    library: Library,
    found: Diagnosis,
    path: Path,
    *,
    model: str,
    fit: Sequence[str],
    validate: Sequence[str] = (),
    first: tuple[Block, ...] = (),
) -> Path:
    """The diagnosis as one HTML file that opens offline; model, fit, validate: as it had them;
    first: blocks before everything else."""
    from pa10d.figures.held_out import held_out
    from pa10d.report.diagnosis_page import diagnosis_page

    asked = asked_of(library, model, fit, validate)
    return write_file(path, diagnosis_page(found, held_out(found), asked, first))


def asked_of(
    library: Library, model: str, fit: Sequence[str], validate: Sequence[str] = ()
) -> Asked:
    """The names that were asked for, as they are stored."""
    from pa10d.report.finding_section import Asked

    fitted, judged = ([library.runs.find(run) for run in runs] for runs in (fit, validate))
    return Asked(
        library.models.find(model).name,
        [info.name for info in fitted],
        [info.name for info in judged],
        fitted[0].profile or "PROFILE",
    )
