"""``pa10d robot …``: state, enable, stop, disable, reset; what the page's buttons do."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, note
from pa10d.cli.commands import Subcommands
from pa10d.cli.daemon_client import daemon_beside
from pa10d.common.jsonable import JsonObject

if TYPE_CHECKING:
    from pa10d.client import Client

AT_REST = ("holding", "inactive", "fault", "offline")
WAITED = 10.0  # s until an arm that was told to stop must have come to rest
BY_SIGNAL = (
    "the daemon did not stop it: control was told by a signal and brings the arm to rest; look at "
    "the arm"
)
GOES_ON = (
    "the daemon goes on with what it was asked for; 'pa10d robot state' says how the arm is, "
    "'pa10d robot stop' brings it to rest"
)


def add_commands(commands: Subcommands) -> None:
    """The family ``robot``."""
    robot = commands.group(
        "robot", "state, enable, stop, disable, reset: the arm of the daemon on this data"
    )
    robot.add(
        "state", state, "how the arm is, and why",
        examples=("pa10d robot state", "pa10d robot state --json"),
    )  # fmt: skip
    enabling = robot.add(
        "enable", enable, "power on, brakes off, hold the arm where it is",
        examples=("pa10d robot enable", "pa10d robot enable --recover"),
    )  # fmt: skip
    enabling.add_argument(
        "--recover", action="store_true",
        help="bring an arm that stands outside its position limits back inside, slowly",
    )  # fmt: skip
    robot.add(
        "stop", stop, "bring the arm to rest along its limits; it stays held",
        examples=("pa10d robot stop",),
    )  # fmt: skip
    disabling = robot.add(
        "disable", disable, "bring the arm to rest, brakes on, power off",
        examples=("pa10d robot disable", "pa10d robot disable --anyway"),
    )  # fmt: skip
    disabling.add_argument(
        "--anyway", action="store_true",
        help="also where a brake does not hold the arm: it sinks",
    )  # fmt: skip
    robot.add(
        "reset", reset, "leave a fault; the arm stays unpowered",
        examples=("pa10d robot reset",),
    )  # fmt: skip


def state(options: argparse.Namespace) -> Answer:
    """``robot state``."""
    with daemon_beside(options, "robot") as client:
        return _told(client.robot())


def enable(options: argparse.Namespace) -> Answer:
    """``robot enable``."""
    with _commanded(options) as client:
        return _told(client.enable(options.recover), "holding")


def stop(options: argparse.Namespace) -> Answer:
    """``robot stop``: whoever commands the arm."""
    from pa10d.client import stop_robot

    robot = stop_robot(options.data, WAITED)
    return Answer({"state": None}, BY_SIGNAL) if robot is None else _told(robot, *AT_REST)


def disable(options: argparse.Namespace) -> Answer:
    """``robot disable``."""
    with _commanded(options) as client:
        return _told(client.disable(options.anyway), "inactive")


def reset(options: argparse.Namespace) -> Answer:
    """``robot reset``."""
    with _commanded(options) as client:
        return _told(client.reset(), "inactive")


@contextlib.contextmanager
def _commanded(options: argparse.Namespace) -> Iterator[Client]:
    """The daemon beside; whoever interrupts is told that the arm is not."""
    with daemon_beside(options, "robot") as client:
        try:
            yield client
        except KeyboardInterrupt:
            raise KeyboardInterrupt(GOES_ON) from None


def _told(robot: JsonObject, *wanted: str) -> Answer:
    """Status 1 where it is in none of the wanted states."""
    found = {key: robot[key] for key in ("profile", "state", "fault", "offline_reason")}
    doubts = [*robot["outside"], *robot["misplaced"], *robot["unheld"]]
    found["doubts"] = [one["sentence"] for one in doubts]
    fault = robot["fault"] or {}
    for line in (robot["offline_reason"], fault.get("sentence"), *found["doubts"]):
        if line:
            note(line)
    lacks = bool(wanted) and robot["state"] not in wanted
    return Answer(found, f"the arm is {robot['state']}", status=1 if lacks else 0)
