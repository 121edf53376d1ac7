"""May the arm be moved now?"""

from __future__ import annotations

from pa10d.api.problems import Problem
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.robot.readiness import refuse_unless_ready


def require_ready(daemon: Daemon, recover: bool = False) -> None:
    """Nothing else moves the arm, and its state allows motion. recover: it is brought back inside
    first, where it stands outside its position limits."""
    if (busy := daemon.busy()) is not None:
        raise Problem("conflict", busy, remedy="wait for it, or cancel it")
    refuse_unless_ready(daemon.robot, recover)
