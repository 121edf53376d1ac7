"""An investigation of recordings alone: the steps one after the other, in this process."""

from __future__ import annotations

from collections.abc import Callable

from pa10d.common.errors import UserError
from pa10d.investigation import course
from pa10d.investigation.archive import Archive
from pa10d.investigation.state import Investigation, Step
from pa10d.investigation.work import compute

Progress = Callable[[float, str], None]
Told = Callable[[Investigation, Step], None]


def carry_out(
    data: str,
    investigation: str,
    progress: Progress,
    told: Told = lambda state, step: None,
) -> Investigation:
    """From where it stands to its end. told: called when a step begins and when it is over."""
    archive = Archive(data)
    with archive.carrying_out(investigation):
        state = archive.load(investigation)
        course.put_back(state, "running")
        while (step := course.next_step(state)) is not None:
            if step.kind == "motion":
                raise UserError(f"{state.name}: its motions need a daemon; expected one to resume")
            try:
                course.needs(state, step)
                course.begun(state, step)
                archive.save(state)
                told(state, step)
                course.done(state, step, compute(data, investigation, step.id, progress))
            except UserError as error:
                course.put_back(state, "failed", str(error))
                archive.save(state)
                raise
            archive.save(state)
            told(state, step)
    return state
