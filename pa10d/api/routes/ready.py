"""May the arm be moved now?"""

from __future__ import annotations

from pa10d.api.problems import Problem
from pa10d.daemon.daemon import MOVING, Daemon
from pa10d.daemon.robot.readiness import refuse_unless_ready


def require_ready(daemon: Daemon) -> None:
    """Nothing else moves the arm, and its state allows motion."""
    busy = [job for job in daemon.jobs.running() if job.kind in MOVING]
    if busy:
        raise Problem(
            "conflict", f"an {busy[0].kind} job is running", remedy="wait for it, or cancel it"
        )
    refuse_unless_ready(daemon.robot)
