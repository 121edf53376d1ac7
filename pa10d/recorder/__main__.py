"""``python -m pa10d.recorder``: the recorder process, started by the daemon."""

from __future__ import annotations

import argparse
import signal
import socket
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.terminal import leave_terminal_to_daemon
from pa10d.common.unhurried_log import log_unhurried
from pa10d.control.mailbox import Mailbox
from pa10d.control.ring import Ring
from pa10d.profile import Profile
from pa10d.recorder.recorder import Recorder
from pa10d.store import RunStore

PAUSE = 0.02  # s between looks at the ring; simulated time is waited for less
SHORT_PAUSE = 0.001


def main() -> None:
    """Serve until the daemon is gone and no run is open."""
    parser = argparse.ArgumentParser(prog="pa10d-recorder")
    parser.add_argument("--profile", type=Path, required=True, help="JSON of a loaded profile")
    parser.add_argument("--joints", nargs="+", required=True, help="names, in order")
    parser.add_argument("--ring", type=Path, required=True)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--pipe", type=int, required=True, help="descriptor of the command pipe")
    given = parser.parse_args()
    log_unhurried("recorder: %(message)s")
    leave_terminal_to_daemon()
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # it ends when the daemon's pipe does
    profile = Profile.model_validate_json(given.profile.read_text())
    ring = Ring.attach(given.ring)
    recorder = Recorder(ring, RunStore(given.data), profile, tuple(given.joints))
    serve(recorder, socket.socket(fileno=given.pipe), ring)


def serve(recorder: Recorder, connection: socket.socket, ring: Ring) -> None:
    """Messages and records, until the pipe closes and the last run is whole."""
    mailbox = Mailbox(connection)
    mailbox.tell({"event": "ready"})
    connection.setblocking(False)
    while not mailbox.closed or recorder.busy:
        while (message := mailbox.take()) is not None:
            mailbox.tell(_answer(recorder, message))
        before = ring.taken
        ended = recorder.drain()
        if ended is not None:
            mailbox.tell({"event": "run", **ended.document()})
        if mailbox.closed:
            recorder.withdraw()
        quick = ring.taken - before > ring.capacity // 8
        mailbox.wait(SHORT_PAUSE if quick else PAUSE)
    recorder.leave()


def _answer(recorder: Recorder, message: JsonObject) -> JsonObject:
    number, what = message.pop("id", None), message.pop("do", None)
    try:
        if what == "announce":
            message["tags"] = tuple(message.get("tags", ()))
            return {"reply": number, "ok": True, "run": recorder.announce(**message).document()}
        if what == "withdraw":
            return {"reply": number, "ok": True, "withdrawn": recorder.withdraw()}
        return {"reply": number, "ok": False, "detail": f"unknown command {what!r}"}
    except (UserError, OSError) as error:
        return {"reply": number, "ok": False, "detail": str(error)}


if __name__ == "__main__":
    main()
