"""The end of a work that found the arm unpowered: so it is left, where its brakes hold it."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

from pa10d.control.brake_proof import why_still_powered
from pa10d.daemon.robot.refusals import CommandRefused

if TYPE_CHECKING:
    from pa10d.daemon.robot.robot import RobotProcess


async def leave_unpowered(robot: RobotProcess, notes: list[str]) -> None:
    """At rest and unpowered; where power stays, ``notes`` say why and what to do."""
    with contextlib.suppress(CommandRefused):
        await robot.disable()
    why = why_still_powered(robot.unheld())
    if why is not None and why not in notes:
        notes.append(why)
