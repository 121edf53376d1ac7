"""Which class carries out a request that moves the arm, and a job of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pa10d.daemon.jobs.jobs import Job, Progress, Report
from pa10d.daemon.motions.experiment import Experiment
from pa10d.daemon.motions.first_motion import FirstMotion
from pa10d.experiments.outcome import Outcome
from pa10d.experiments.request import MotionRequest

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon


def experiment_of(
    daemon: Daemon, request: MotionRequest, report: Progress
) -> Experiment | FirstMotion:
    """Ready to be carried out."""
    kind = FirstMotion if request.is_first else Experiment
    return kind(daemon, request, report)


def experiment_job(daemon: Daemon, request: MotionRequest) -> Job:
    """Start one as a job. What is known so far is the job's result, also if it fails."""

    async def work(report: Report) -> Outcome:
        experiment = experiment_of(daemon, request, report)
        report.job.result = experiment.result
        return await experiment.carry_out()

    return daemon.move("experiment", request.document(), work)
