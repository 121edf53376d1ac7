"""``python -m pa10d.control``: the control process, started by the daemon."""

from __future__ import annotations

import argparse
import faulthandler
import os
import signal
import socket
from pathlib import Path

from backends.registry import open_backend
from pa10d.common.errors import UserError
from pa10d.common.terminal import leave_terminal_to_daemon
from pa10d.common.unhurried_log import log_unhurried
from pa10d.control.build import build_arm, servo_factory
from pa10d.control.commands import Commands
from pa10d.control.faults import LONGEST
from pa10d.control.guard import BackendBroke, asked
from pa10d.control.loop import Loop
from pa10d.control.mailbox import Mailbox
from pa10d.control.realtime import prepare
from pa10d.control.ring import Ring
from pa10d.dynamics import robot_from_profile
from pa10d.profile import Profile


def main() -> None:
    """Run the loop for as long as the daemon lives; what ends it before that is told in words."""
    parser = argparse.ArgumentParser(prog="pa10d-control")
    parser.add_argument("--profile", type=Path, required=True, help="JSON of a loaded profile")
    parser.add_argument("--ring", type=Path, required=True)
    parser.add_argument("--pipe", type=int, required=True, help="descriptor of the command pipe")
    given = parser.parse_args()
    log_unhurried("control: %(message)s")
    leave_terminal_to_daemon()
    faulthandler.enable()  # where it hung stands in the log, when the daemon ends it for that
    connection = socket.socket(fileno=given.pipe)
    try:
        control(given.profile, given.ring, connection)
    except Exception as error:
        known = isinstance(error, UserError | BackendBroke)
        why = str(error) if known else f"{type(error).__name__}: {error}"
        Mailbox(connection).tell({"event": "ends", "why": why[:LONGEST]})
        if known:
            raise SystemExit(1) from None
        raise


def control(about: Path, shared: Path, connection: socket.socket) -> None:
    """Attach to the ring, say ready, run the loop."""
    profile = Profile.model_validate_json(about.read_text())
    robot = robot_from_profile(profile)
    backend = asked("open_backend", open_backend, profile)
    ring = Ring.attach(shared)
    ring.writer = os.getpid()
    arm = build_arm(profile, robot, backend, ring)
    commands = Commands(arm, robot, servo_factory(profile, robot, backend.period))
    loop = Loop(arm, ring, commands, connection)
    signal.signal(signal.SIGTERM, lambda *_: loop.end("told to terminate"))
    signal.signal(signal.SIGUSR1, lambda *_: loop.stop())
    notes = prepare() if backend.realtime else []
    loop.tell({"event": "ready", "notes": notes, "realtime": backend.realtime})
    loop.run()


if __name__ == "__main__":
    main()
