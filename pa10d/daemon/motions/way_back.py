"""An arm that stands outside its position limits is powered and brought back inside: for who asks
for that, and for nobody else."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pa10d.control.outside import why_not_powered
from pa10d.daemon.motions.numbers import NUMBERS, SHIFTED, STOPPED
from pa10d.daemon.robot.refusals import CommandRefused, stands_outside

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon


async def bring_inside(daemon: Daemon) -> None:
    """Until the arm is held inside; nothing but ``enable`` where it stands inside already.
    CommandRefused or UserError where it stays outside: on the way it meets something, a fault or a
    stop."""
    robot = daemon.robot
    if not robot.outside():
        await robot.enable()
        return
    number = next(NUMBERS)
    file = daemon.runtime / f"way-back-{number}.npy"
    try:
        planned = robot.pose()
        rows = await _plan(daemon, planned, str(file))
        await robot.enable(recover=True)
        held = robot.pose()
        if np.abs(held - planned).max() > SHIFTED:
            rows = await _plan(daemon, held, str(file))
        if robot.state == "holding":
            await robot.follow(str(file), number, rows, rows)
            seconds = rows / daemon.profile.control.rate
            await robot.until("holding", "inactive", "fault", "offline", timeout=seconds + STOPPED)
    except BaseException:
        robot.stop()  # it may be powered or on its way, and nobody been told yet
        raise
    finally:
        file.unlink(missing_ok=True)
    if robot.state != "holding" or robot.outside():
        raise CommandRefused(stands_outside("recover", robot.state, _why(daemon)))


def _why(daemon: Daemon) -> str:
    """What kept the arm outside."""
    robot = daemon.robot
    if robot.fault is not None:
        return robot.fault.sentence
    left = why_not_powered(robot.outside(), recover=False)
    return f"the arm was stopped on its way back inside; {left or 'it is inside now'}"


async def _plan(daemon: Daemon, start: np.ndarray, file: str) -> int:
    rows: int = await daemon.desk.run(
        "pa10d.services.way_back:plan_way_back", lambda *_: None,
        profile=str(daemon.profile.path), start=start.tolist(), file=file,
    )  # fmt: skip
    return rows
