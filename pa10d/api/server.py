"""``pa10d serve``: the daemon with its API on a port."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import os
import resource
import secrets
import signal
import socket
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

import uvicorn

from backends.arm_lock import refuse_arm_of_others
from pa10d.api.access import Access
from pa10d.api.app import create_app
from pa10d.api.listeners import LARGEST, listeners
from pa10d.common.errors import UserError
from pa10d.common.terminal import hang_up_ends
from pa10d.common.unhurried_log import log_unhurried
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.night import Secret
from pa10d.daemon.presence import LOCK, Presence, announced, present
from pa10d.daemon.processes.runtime import own, runtime_folder
from pa10d.daemon.processes.simulator import refuse_no_arm, wants_simulator
from pa10d.dynamics import Robot
from pa10d.profile import Profile

PATIENCE = 20.0  # s for which an older daemon's control process may still bring its arm to rest
LOOPBACK = ("127.0.0.1", "::1", "localhost")
RECEIVED = 1 << 15  # bytes taken from one client in one go, before others are heard
MAY_TAKE = 5  # s for open requests once told to end

log = logging.getLogger("pa10d")


@dataclass(frozen=True)
class Settings:
    """How to serve. Port 0: a free one. Without tokens only loopback addresses are allowed.

    attached: end when standard input ends; secret: what the virtual arm hides; ready: called once
    requests are answered.
    """

    data: Path
    host: str = "127.0.0.1"
    port: int = 8010
    tokens: dict[str, str] = field(default_factory=dict)
    names: tuple[str, ...] = ()
    simulator: bool = True
    as_json: bool = False
    attached: bool = False
    secret: Secret | None = None
    ready: Callable[[], None] = lambda: None


def serve(profile: Profile, robot: Robot, settings: Settings) -> None:
    """Until told to end (SIGTERM, SIGINT, the end of its terminal); the arm is at rest then, brakes
    on."""
    if settings.host not in LOOPBACK and not settings.tokens:
        raise UserError(
            f"--host {settings.host}: other machines could command the arm; expected a loopback "
            "address, or tokens (--token-file, PA10D_TOKEN)"
        )
    ends = [signal.SIGTERM, *([signal.SIGHUP] if hang_up_ends() else [])]
    for number in ends:
        signal.signal(number, lambda *_: sys.exit(0))
    signal.signal(signal.SIGUSR1, signal.SIG_IGN)  # all our processes inherit it; control stops
    _open_files()
    log_unhurried("%(name)s: %(message)s")
    logging.getLogger("pa10d").setLevel(logging.INFO)
    with contextlib.ExitStack() as stack:
        listener = stack.enter_context(_listen(settings.host, settings.port))
        lock = stack.enter_context(_sole_daemon(settings.data))
        if settings.simulator and wants_simulator(profile):
            refuse_arm_of_others(profile)
            refuse_no_arm(profile)
        runtime = stack.enter_context(runtime_folder())
        daemon = Daemon(
            profile, robot, settings.data, runtime,
            simulator=settings.simulator, inherit=(lock.fileno(),), secret=settings.secret,
        )  # fmt: skip
        url = _url(settings.host, listener.getsockname()[1])
        tokens = dict(settings.tokens)
        presence = Presence(url, os.getpid(), profile.name, _token(tokens))
        access = Access(tokens, frozenset(settings.names))

        def ready() -> None:
            settings.ready()
            stack.enter_context(announced(settings.data, presence))
            if settings.as_json:
                print(json.dumps({"url": url, "pid": os.getpid()}), flush=True)
            else:
                print(f"pa10d serves {profile.name} on {url}", file=sys.stderr, flush=True)

        config = uvicorn.Config(
            create_app(daemon, access, ready), log_level="warning", log_config=None,
            lifespan="on", loop="asyncio", server_header=False, access_log=False,
            timeout_graceful_shutdown=MAY_TAKE,
            ws=listeners(), ws_max_size=LARGEST, ws_per_message_deflate=False,
        )  # fmt: skip
        if settings.attached:
            threading.Thread(target=_end_with_input, daemon=True).start()
        server = _Server(config, daemon)
        # uvicorn raises it once more when it is down: there is still something to clear away
        for number in ends:
            signal.signal(number, server.handle_exit)
        server.run(sockets=[listener])


class _Server(uvicorn.Server):
    """The arm does not wait for open requests: it comes to rest as soon as we are told to end."""

    def __init__(self, config: uvicorn.Config, daemon: Daemon) -> None:
        super().__init__(config)
        self._daemon = daemon

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        await asyncio.gather(self._daemon.close(), super().shutdown(sockets))
        # a worker that ends after the loop is nobody's news
        logging.getLogger("asyncio").setLevel(logging.ERROR)


def _open_files() -> None:
    """As many connections as the system allows: whoever uses them up must not keep 'stop' out."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = hard if hard != resource.RLIM_INFINITY else 1 << 16
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(most, 1 << 16), hard))


def _end_with_input() -> None:
    """Whoever started us has the other end, open for as long as they live."""
    while os.read(sys.stdin.fileno(), 4096):
        pass
    os.kill(os.getpid(), signal.SIGTERM)


def _listen(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVED)
    try:
        listener.bind((host, port))
        listener.listen(1024)
    except OSError as error:
        listener.close()
        raise UserError(
            f"--port {port}: {error.strerror}; expected a free port (0 picks one)"
        ) from error
    return listener


def _sole_daemon(data: Path) -> IO[str]:
    other = present(data)
    if other is not None:
        raise UserError(f"{data}: a daemon runs here already ({other.url}, process {other.pid})")
    taken = f"{data}: another daemon, or its control process, still holds this data folder"
    return own(data / LOCK, PATIENCE, taken)


def _token(tokens: dict[str, str]) -> str | None:
    """With tokens in force the user's own command line needs one, too."""
    if not tokens:
        return None
    return tokens.setdefault("admin", secrets.token_urlsafe(24))


def _url(host: str, port: int) -> str:
    shown = f"[{host}]" if ":" in host else host
    return f"http://{shown}:{port}"
