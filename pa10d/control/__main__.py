"""``python -m pa10d.control``: the control process, started by the daemon."""

from __future__ import annotations

import argparse
import logging
import os
import signal
import socket
from pathlib import Path

from backends.registry import open_backend
from pa10d.control.build import build_arm, servo_factory
from pa10d.control.commands import Commands
from pa10d.control.loop import Loop
from pa10d.control.realtime import prepare
from pa10d.control.ring import Ring
from pa10d.dynamics import robot_from_profile
from pa10d.profile import Profile


def main() -> None:
    """Attach to the ring, say ready, run the loop."""
    parser = argparse.ArgumentParser(prog="pa10d-control")
    parser.add_argument("--profile", type=Path, required=True, help="JSON of a loaded profile")
    parser.add_argument("--ring", type=Path, required=True)
    parser.add_argument("--pipe", type=int, required=True, help="descriptor of the command pipe")
    given = parser.parse_args()
    logging.basicConfig(level=logging.WARNING, format="control: %(message)s")
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    connection = socket.socket(fileno=given.pipe)
    profile = Profile.model_validate_json(given.profile.read_text())
    robot = robot_from_profile(profile)
    backend = open_backend(profile)
    ring = Ring.attach(given.ring)
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
