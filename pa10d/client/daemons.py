"""Daemons that a client may talk to: one that runs, or one of its own."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from pa10d.client.client import Client
from pa10d.client.connection import Silent
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject

ANSWERS = 1.0  # s within which a stop that goes well is answered, tenfold
SILENT = 10.0  # s after which a daemon stands still, however busy the machine
STANDS = (
    "the daemon on this data, process {}, does not answer; 'pa10d robot stop' brings its arm to "
    "rest all the same"
)
NONE_RUNS = (
    "stop: no daemon runs on this data; control processes of others stop their arms at "
    "'pkill -USR1 -f pa10d.control'"
)
START = 180.0  # s for a daemon to come up; compiled code may have to be made first


def running_daemon(data: str | os.PathLike[str] | None = None) -> Client | None:
    """A client of the daemon that runs on this data, if there is one; UserError where that is
    silent."""
    from pa10d.daemon.presence import present
    from pa10d.store.location import data_folder

    found = present(data_folder(data))
    if found is None:
        return None
    try:
        with Client(found.url, found.token, patience=SILENT) as client:
            client.health()
    except Silent as error:
        raise UserError(STANDS.format(found.pid)) from error
    except UserError:
        return None
    return Client(found.url, found.token)


def stop_robot(data: str | os.PathLike[str] | None, wait: float) -> JsonObject | None:
    """Stop the arm of the daemon on this data: what that says once the arm rests, or after
    ``wait`` s. None where it does not, or refuses: then its control process was told by a signal.
    UserError where there is neither."""
    from pa10d.daemon.presence import present
    from pa10d.daemon.second_stop import stop_by_signal
    from pa10d.store.location import data_folder

    found = present(data_folder(data))
    if found is None:
        raise UserError(NONE_RUNS)
    try:
        with Client(found.url, found.token, patience=ANSWERS) as client:
            robot = client.stop(wait=0.0)
    except UserError as error:
        if stop_by_signal(found.pid):
            return None
        raise UserError(f"stop: {error}; nor is there a control process to signal") from error
    with contextlib.suppress(UserError), Client(found.url, found.token) as client:
        return client.stop(wait=wait)
    return robot


@contextlib.contextmanager
def daemon_serving(
    data: str | os.PathLike[str] | None, file: str | os.PathLike[str]
) -> Iterator[Client | None]:
    """The daemon on this data where it serves the profile in ``file``, and goes on with what is
    changed of it; None: whoever asks changes the file himself. Command is given back at the end."""
    client = running_daemon(data)
    if client is None:
        yield None
        return
    with client:
        if client.tuning()["file"] != os.fspath(file):
            yield None
            return
        try:
            yield client
        finally:
            client.let_others_command()


@contextlib.contextmanager
def local_daemon(
    data: str | os.PathLike[str],
    profile: str = "pa10-sim",
    *,
    channel: str | None = None,
    clock: str | None = None,
) -> Iterator[Client]:
    """A daemon of our own, with its virtual arm where the profile has one, on a free port.

    channel: a bus of its own; default: one that nobody else uses. clock: ``simulated`` runs as
    fast as this machine can. Everything ends with the block, the arm at rest.
    """
    from pa10d.daemon.processes.simulator import wants_simulator
    from pa10d.profile import load_profile

    command = [sys.executable, "-m", "pa10d", "--data", str(data), "--json", "serve"]
    command += ["--profile", profile, "--port", "0", "--attached"]
    if channel is None and wants_simulator(load_profile(profile)):
        channel = f"local-{os.getpid()}-{time.time_ns() % 10**9}"
    command += ["--channel", channel] if channel else []
    command += ["--clock", clock] if clock else []
    # a group of its own: an interrupt from the terminal is for us, who end it in good order; should
    # we be killed, the end of its input tells it
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, process_group=0
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        line = process.stdout.readline()
        said = json.loads(line) if line.startswith("{") else {}
        if "url" not in said:
            raise UserError(said.get("error") or "the daemon did not start; its messages are above")
        with running_at(said["url"], data) as client:
            yield client
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(30)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdin.close()
        process.stdout.close()


@contextlib.contextmanager
def running_at(url: str, data: str | os.PathLike[str]) -> Iterator[Client]:
    """A client once the robot answers."""
    from pa10d.daemon.presence import present

    found = present(Path(data))
    with Client(url, found.token if found else None) as client:
        client.wait_for_robot("inactive", timeout=START)
        yield client
