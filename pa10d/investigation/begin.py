"""The beginning of an investigation: what is asked for, checked, with its motions and their times.

Nothing moves here, and nothing is computed but plans.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from pa10d.common.errors import UserError
from pa10d.investigation.archive import Archive
from pa10d.investigation.course import first_steps
from pa10d.investigation.motions import MotionPreview, keep_previews, previews
from pa10d.investigation.state import Investigation, Question
from pa10d.services.library import Library, open_library
from pa10d.services.robots import load_robot
from pa10d.store.names import checked_name, new_id

MINUTES = 15.0  # of motion, unless somebody says otherwise
NAME = "investigation"
UNMEASURED = (
    "first_motion, which measures the joints, cannot be run, and nothing larger is moved before it"
)


def begin(
    data: str,
    profile: str,
    *,
    name: str | None = None,
    minutes: float | None = None,
    since: str | None = None,
    fit: Sequence[str] = (),
    validate: Sequence[str] = (),
    force: bool = False,
    keep: bool = True,
    progress: Any = lambda share, what: None,
) -> tuple[Investigation, list[MotionPreview]]:
    """A new investigation, kept unless it is for looking only, and its motions.

    minutes: of motion; fit, validate: recordings, and then nothing moves; since: a model, to ask
    what has changed since then
    """
    found, robot = load_robot(profile)
    library, archive = open_library(data), Archive(data)
    _refuse_contradictions(minutes, fit, validate)
    question: Question = "missing" if since is None else "changed"
    model = None if since is None else library.models.find(since)
    to_fit = [library.runs.find(run).id for run in fit]
    to_judge = [library.runs.find(run).id for run in validate]
    named = _name(library, archive, name)
    seen = [] if fit else previews(data, found, robot, question, progress)
    asked = [(one.motion, "; ".join(one.problems)) for one in seen]
    for motion, problem in asked:
        if motion.kind == "first_motion" and problem:
            raise UserError(f"{found.path}: {UNMEASURED}: {problem}")
    if seen and not any(m.purpose == "fit" and not problem for m, problem in asked):
        raise UserError(
            f"{found.path}: no motion can be planned that a model could be fitted to: "
            + next(problem for m, problem in asked if m.purpose == "fit")
        )
    limit = None if fit else minutes or MINUTES
    steps = first_steps(asked, question, limit)
    state = Investigation(
        id=new_id(os.listdir(archive.folder)), name=named,
        created=datetime.now(UTC).isoformat(timespec="milliseconds"),
        profile=str(found.path),
        robot=found.name, question=question, moves=not fit, minutes=limit,
        fit=to_fit, validate_=to_judge, model=None if model is None else model.id, force=force,
        steps=steps,
    )  # fmt: skip
    if keep:
        archive.save(state)
        keep_previews(archive.place(state.id), seen)
    return state, seen


def _refuse_contradictions(
    minutes: float | None, fit: Sequence[str], validate: Sequence[str]
) -> None:
    if validate and not fit:
        raise UserError("--validate: given without --fit; expected runs to fit a model to, too")
    if fit and minutes is not None:
        raise UserError(
            "--minutes: given with --fit; expected either a budget of motion or recordings, with "
            "which nothing moves"
        )
    if minutes is not None and not 0 < minutes <= 1440:
        raise UserError(f"--minutes {minutes:g}: expected more than 0 and at most 1440")


def _name(library: Library, archive: Archive, wanted: str | None) -> str:
    """The name asked for, if no models of that name are there, or the first free one."""
    taken = {info.name for info in library.models.all()} | {one.name for one in archive.all()}

    def free(name: str) -> bool:
        return name not in taken and f"{name}-m0" not in taken

    if wanted is not None:
        if not free(checked_name(wanted)):
            raise UserError(
                f"--name {wanted}: there is one already, or models of that name; expected another "
                "name"
            )
        return wanted
    k = 1
    while not free(name := NAME if k == 1 else f"{NAME}-{k}"):
        k += 1
    return name
