"""``python -m pa10d.daemon.processes.worker``: computes one thing at a time, at low priority.

Reads one JSON line per task from its pipe, ``{"call": "package.module:function", "arguments":
{…}}``, and answers with a line ``{"begun"}``, lines ``{"progress", "message"}`` and, last,
``{"result"}`` or ``{"error", "expected"}``. The daemon cancels a task by ending this process.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import inspect
import json
import logging
import os
import resource
import signal
import socket
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pa10d.common.disk import disk_words, of_the_disk
from pa10d.common.errors import NoRoom, Taken, Unsound, UserError
from pa10d.common.jsonable import JsonObject, plain
from pa10d.common.loading import loading
from pa10d.common.terminal import leave_terminal_to_daemon
from pa10d.common.unhurried_log import log_unhurried

FIRST_TO_GO = 600  # oom_score_adj; the service itself is below 0
ALLOWED = ("pa10d.daemon.jobs.tasks", "pa10d.services.")

Progress = Callable[[float, str], None]


class Gone(BaseException):
    """Nobody waits for an answer any more: the daemon has ended. No task is to take it for a fault
    of its own, on whatever level it was about to tell how far it is."""


def main() -> None:
    """Serve until the daemon closes the pipe."""
    parser = argparse.ArgumentParser(prog="pa10d-worker")
    parser.add_argument("--pipe", type=int, required=True)
    parser.add_argument("--nice", type=int, required=True)
    parser.add_argument("--memory", type=int, required=True, help="bytes it may take")
    given = parser.parse_args()
    log_unhurried("worker: %(message)s", logging.INFO)
    leave_terminal_to_daemon()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    os.nice(given.nice)
    restrain(given.memory)
    connection = socket.socket(fileno=given.pipe)
    lines = connection.makefile("rb")

    def say(message: JsonObject) -> None:
        text = json.dumps(message, allow_nan=False).encode() + b"\n"
        try:
            connection.sendall(text)
        except (BrokenPipeError, ConnectionResetError) as error:
            raise Gone from error

    with contextlib.suppress(Gone, ConnectionResetError):
        for line in lines:
            say({"begun": True})
            say(carry_out(json.loads(line), say))


def restrain(memory: int) -> None:
    """What asks for more is told no; where the machine runs out all the same, this process goes
    before the daemon, the recorder and control."""
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(str(FIRST_TO_GO))


def carry_out(task: JsonObject, say: Callable[[JsonObject], None]) -> JsonObject:
    """Do one task; never raises for what the task did."""

    def progress(share: float, message: str = "") -> None:
        say({"progress": round(float(share), 4), "message": message})

    try:
        function, arguments = resolve(task["call"]), dict(task["arguments"])
        if "progress" in inspect.signature(function).parameters:
            arguments["progress"] = progress
        return {"result": plain(function(**arguments))}
    except Unsound as error:
        return {"error": str(error), "expected": True, "findings": error.findings}
    except NoRoom as error:
        return {"error": str(error), "expected": True, "no_room": True}
    except Taken as error:
        return {"error": str(error), "expected": True, "taken": True}
    except UserError as error:
        return {"error": str(error), "expected": True}
    except MemoryError:
        most = resource.getrlimit(resource.RLIMIT_DATA)[0] / 2**30
        said = f"needs more than the {most:.3g} GiB of memory that one job may take"
        return {"error": said, "expected": True, "spent": True}
    except OSError as error:
        if not of_the_disk(error):
            logging.error("%s", traceback.format_exc())
            return {"error": f"{type(error).__name__}: {disk_words(error)}", "expected": False}
        what = disk_words(error, "nothing was stored", "data folder")
        return {"error": what, "expected": True, "no_room": True}
    except Exception as error:
        logging.error("%s", traceback.format_exc())
        return {"error": f"{type(error).__name__}: {error}", "expected": False}


def resolve(call: str) -> Callable[..., Any]:
    """The function behind ``package.module:function``, of our own rooms only."""
    module, _, name = call.partition(":")
    if not module.startswith(ALLOWED):
        raise UserError(f"{call}: not a service")
    with loading():
        function: Callable[..., Any] = getattr(importlib.import_module(module), name)
    return function


if __name__ == "__main__":
    main()
