"""What the daemon itself knows of an arm that is to move: its state, its bus, its drives."""

from __future__ import annotations

import numpy as np

from pa10d.control.outside import why_not_powered
from pa10d.control.whereabouts import why_not_believed
from pa10d.daemon.robot.refusals import CommandRefused, not_believed, stands_outside
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.experiments.checks import Check


def readiness(robot: RobotProcess) -> list[Check]:
    """The part of a pre-check that no plan changes."""
    try:
        refuse_unless_ready(robot)
    except CommandRefused as refusal:
        remedy = refusal.answer["remedy"]
        text = str(refusal) if remedy in str(refusal) else f"{refusal}; {remedy}"
        return [Check("error", "state", text)]
    return [Check("ok", "state", f"the arm is {robot.state}"), *_bus(robot), *_drives(robot)]


def refuse_unless_ready(robot: RobotProcess, recover: bool = False) -> None:
    """Before a job is made of it: CommandRefused where the arm's state does not allow motion.
    recover: it is brought back inside first, where it stands outside its position limits."""
    if robot.state in ("inactive", "holding"):
        if (doubt := why_not_believed(robot.misplaced())) is not None:
            raise CommandRefused(not_believed("experiment", robot.state, doubt))
        if (stray := why_not_powered(robot.outside(), recover)) is not None:
            raise CommandRefused(stands_outside("experiment", robot.state, stray))
        return
    remedies = {
        "offline": "wait until the robot is connected, or connect it",
        "fault": "remove the cause, then reset",
    }
    remedy = remedies.get(robot.state, "wait for the motion to end, or stop it")
    why = robot.why_offline if robot.state == "offline" else robot.fault and robot.fault.sentence
    raise CommandRefused(
        {
            "state": robot.state,
            "needed": ["inactive", "holding"],
            "detail": f"experiment: the arm is {robot.state}" + (f": {why}" if why else ""),
            "remedy": remedy,
        }
    )


def _bus(robot: RobotProcess) -> list[Check]:
    wire = robot.device.wire(robot.profile)
    if wire is None:
        return []
    return [Check("ok" if wire.fits else "error", "bus", wire.sentence())]


def _drives(robot: RobotProcess) -> list[Check]:
    last = robot.ring.last()
    if last is None:
        return [Check("error", "drives", "no drive was heard yet; wait a second")]
    late = robot.ring.layout.get(last, "age") >= robot.profile.safety.stale_cycles
    silent = [
        Check("error", "drives", f"joint {j + 1}: its drive does not answer", int(j) + 1)
        for j in np.flatnonzero(late)
    ]
    warned = [
        Check("warning", "drives", f"joint {j + 1}: {remark}", j + 1)
        for j, word in enumerate(robot.ring.layout.get(last, "status"))
        for remark in robot.device.remarks(int(word))
    ]
    return [*(silent or [Check("ok", "drives", "every drive answers in every cycle")]), *warned]
