"""Whether a recording may be fitted or judged by: errors of the checks stop it, unless forced.

An error is what would make a fit wrong, such as degrees for radians. A run brought in from a file
keeps what its checks said; what was recorded here is looked at when it is asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pa10d.checks import CheckFinding, check_recording
from pa10d.common.errors import Unsound, UserError
from pa10d.dynamics.robot import Robot
from pa10d.measurement.recording import Recording
from pa10d.store import RunInfo


def errors_of(
    info: RunInfo, recording: Recording | None = None, robot: Robot | None = None
) -> list[CheckFinding]:
    """What stands against a fit; without the recording only what is kept with the run."""
    if info.findings is not None:
        found = [CheckFinding(**kept) for kept in info.findings]
    elif recording is not None and (robot is None or robot.n == recording.joints):
        found = check_recording(recording, None, robot, delay=False)
    else:
        found = []
    return [finding for finding in found if finding.severity == "error"]


READ_WRONG = frozenset({"turned", "order", "torque_scale", "clock", "clipped"})
"""Findings that would explain more of a misfit than any effect."""


def read_wrong(infos: Iterable[RunInfo]) -> tuple[str, ...]:
    """What the checks of runs said when they were brought in, and whoever fits them ought to hear
    again: columns that may be another's, turned round, in another unit, on another clock, clipped,
    and every error, which was forced."""
    return tuple(
        f"run {info.name}: {kept['sentence']}, as its check said → {kept['advice']}"
        for info in infos
        for kept in info.findings or ()
        if kept["severity"] == "error"
        or (kept["code"] in READ_WRONG and kept["severity"] == "warning")
    )


def refuse_unsound(
    infos: Sequence[RunInfo],
    recordings: Sequence[Recording] | None = None,
    robot: Robot | None = None,
    *,
    force: bool = False,
) -> None:
    """Unsound where one of these runs has an error against it; ``force`` lets it pass. One that is
    being recorded is no run yet: its model would be said to know all of it."""
    for info in infos:
        if info.status == "started":
            raise UserError(f"run {info.name!r}: it is being recorded; expected a finished run")
    if force:
        return
    given = [None] * len(infos) if recordings is None else recordings
    for info, recording in zip(infos, given, strict=True):
        errors = errors_of(info, recording, robot)
        if errors:
            raise unsound(f"run {info.name!r}", errors)


def unsound(
    what: str, errors: Sequence[CheckFinding], warnings: Sequence[CheckFinding] = ()
) -> UserError:
    """One line for all errors; the findings beside, with what else has to be mended."""
    said = "; ".join(f"{e.sentence}{f' → {e.advice}' if e.advice else ''}" for e in errors)
    return Unsound(
        f"{what}: {said}. A fit would be wrong: mend the recording, or force it",
        [finding.document() for finding in (*errors, *warnings)],
    )
