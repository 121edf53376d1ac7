"""An investigation carried out by the daemon: motions by the arm, everything else by workers.

The job may end at any moment: by a pause or a stop, by a fault, or with the daemon. What is done
is in the investigation's file; the same call goes on from there.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pa10d.common.errors import NotNow, Stopped, UserError
from pa10d.common.jsonable import JsonObject, parsed
from pa10d.common.words import sentence
from pa10d.daemon.jobs.jobs import Job, Progress, Report, part
from pa10d.daemon.motions.kinds import experiment_of
from pa10d.experiments.request import MotionRequest
from pa10d.investigation import course
from pa10d.investigation.document import document
from pa10d.investigation.results import StepOutcome
from pa10d.investigation.state import Investigation, Step

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon

MOVES, RECORDINGS = "investigation", "analysis"
"""Kinds of jobs: the first moves the arm."""

TAGS = {"fit": ["fit"], "judge": ["judge"], "settle": ["fit", "judge"], "fresh": ["fresh"]}
ABLE = ("inactive", "holding")  # states from which an arm may be moved
SEARCH, OTHER = 30.0, 5.0  # s that computing takes, roughly, for the bar
SPENT = "The motions before it took longer than expected: it is beyond the budget."
STOPPED = "it was stopped; what is done stays done"


def investigation_job(daemon: Daemon, state: Investigation, recover: bool = False) -> Job:
    """Begin it, or go on with it, as a job; its result is that of ``pa10d investigate``. recover:
    see ``MotionRequest``."""

    async def work(report: Report) -> Any:
        return await _Carrier(daemon, state.id, report, recover).carry_out()

    kind = MOVES if state.moves else RECORDINGS
    return daemon.move(kind, {"investigation": state.id, "name": state.name}, work)


class _Carrier:
    def __init__(self, daemon: Daemon, investigation: str, report: Report, recover: bool) -> None:
        self._daemon, self._id, self._report = daemon, investigation, report
        self._recover = recover
        self._archive = daemon.investigations

    async def carry_out(self) -> JsonObject:
        lock = self._archive.carrying_out(self._id)
        await asyncio.to_thread(lock.__enter__)
        try:
            state = await asyncio.to_thread(self._archive.load, self._id)
            course.put_back(state, "running")
            await self._all_steps(state)
            return await asyncio.to_thread(document, state, str(self._daemon.data))
        finally:
            self._daemon.pauses.discard(self._id)
            lock.__exit__(None, None, None)

    async def _all_steps(self, state: Investigation) -> None:
        while (step := course.next_step(state)) is not None:
            if self._id in self._daemon.pauses:
                course.put_back(state, "paused")
                await self._save(state)
                return
            if course.spent(state, step):
                course.left_out(state, step, SPENT)
                await self._save(state)
                continue
            try:
                course.needs(state, step)
                course.begun(state, step)
                await self._save(state)
                await self._one(state, step)
            except (asyncio.CancelledError, Stopped):
                course.put_back(state, "stopped", STOPPED)
                await asyncio.shield(self._save(state))
                raise
            except BaseException as error:
                course.put_back(state, "failed", str(error) or type(error).__name__)
                with contextlib.suppress(OSError):  # a full disk is told as what it is
                    await self._save(state)
                raise
            await self._save(state)

    async def _one(self, state: Investigation, step: Step) -> None:
        told = self._told(state, step)
        if step.motion is None:
            work = self._daemon.compute_now(
                "investigation_step", told, investigation=self._id, step=step.id
            )
            # who stops an arm is not to be told of motions to come, nor that all went to its end
            outcome = await (self._daemon.robot.stops.unless(work) if state.moves else work)
            course.done(state, step, parsed(StepOutcome, outcome))
            return
        await self._move(state, step, told)

    async def _move(self, state: Investigation, step: Step, told: Progress) -> None:
        """A motion that the pre-check refuses is left out. A fault or a stop ends the job, and so
        does what may be otherwise in a while, as a full disk, and the refusal of what measures the
        joints, without which nothing larger is moved: the step is still to be done."""
        assert step.motion is not None
        tags = [*TAGS.get(step.motion.purpose, []), state.name]
        asked = step.motion
        request = MotionRequest(asked.kind, asked.parameters, tags=tags, recover=self._recover)
        experiment = experiment_of(self._daemon, request, told)
        try:
            found = await experiment.carry_out()
        except UserError as error:
            passes = isinstance(error, Stopped | NotNow)  # no lack of the motion's own
            passes = passes or asked.kind == "first_motion"
            if passes or experiment.moved or self._daemon.robot.state not in ABLE:
                raise
            course.left_out(state, step, str(error))
            return
        names = [run.name for run in found.recorded]
        advice = found.recommendation or [""]
        said = f"Recorded {', '.join(names)}." if names else advice[0]
        moved, words = found.seconds or 0.0, " ".join([said, *map(sentence, found.notes)])
        tuned = [*map(sentence, found.tuned)]
        done = StepOutcome(runs=found.runs, moved=moved, said=words, tuned=tuned)
        course.done(state, step, done)

    def _told(self, state: Investigation, step: Step) -> Progress:
        """The job's progress by the steps that are over; its message begins with this one's id."""
        times = [_time(one) for one in state.steps if one.status != "left_out"]
        over = sum(_time(one) for one in state.steps if one.status == "done")
        inner: Callable[[float, str], None] = part(
            self._report, over / sum(times), min(1.0, (over + _time(step)) / sum(times))
        )

        def tell(share: float, message: str = "") -> None:
            inner(share, f"{step.title}: {message}" if message else step.title)

        return tell

    async def _save(self, state: Investigation) -> None:
        await asyncio.to_thread(self._archive.save, state)
        self._daemon.events.publish("investigation", {"id": state.id, "status": state.status})


def _time(step: Step) -> float:
    """s, roughly."""
    if step.motion is not None:
        return step.motion.seconds
    return SEARCH if step.kind == "diagnose" else OTHER
