"""Where the nodes of a channel find each other: a private folder of listening sockets."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import secrets
import socket
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

from pa10d.common.locked_file import still_there

NAME = re.compile(r"[A-Za-z0-9._-]{1,40}")


def _base() -> Path:
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    if runtime and os.access(runtime, os.W_OK):
        return Path(runtime) / "pa10d-virtualbus"
    # not TMPDIR: processes with different ones must meet, and a socket path is short
    fallback = Path("/tmp") if os.access("/tmp", os.W_OK) else Path(tempfile.gettempdir())
    return fallback / f"pa10d-virtualbus-{os.getuid()}"


def channel_folder(channel: str) -> Path:
    """The channel's folder, made if need be; only its owner may enter (else PermissionError).

    FileNotFoundError where the last node takes it away meanwhile: ``alone`` tries again.
    """
    if not NAME.fullmatch(channel) or channel in (".", ".."):
        raise ValueError(f"virtualbus channel '{channel}': expected 1-40 of letters, digits, . _ -")
    folder = _base() / channel
    _make_private(folder.parent)
    _make_private(folder)
    return folder


def _make_private(path: Path) -> None:
    """Not ``Path.mkdir(exist_ok=True)``: it says "exists" of what has just gone."""
    with contextlib.suppress(FileExistsError):
        os.mkdir(path, 0o700)
    found = path.lstat()
    if not stat.S_ISDIR(found.st_mode):
        raise NotADirectoryError(f"{path}: expected a folder for the nodes of the bus")
    if found.st_uid != os.getuid() or found.st_mode & 0o077:
        raise PermissionError(f"{path}: not private to this user, the bus would not be either")


def channels() -> list[str]:
    """Channels on which somebody listens or listened."""
    base = _base()
    return sorted(p.name for p in base.iterdir() if p.is_dir()) if base.is_dir() else []


@contextlib.contextmanager
def alone(channel: str) -> Iterator[Path]:
    """The channel's folder, for one at a time: newcomers must not connect to each other twice."""
    while True:
        try:
            folder = channel_folder(channel)
            lock = open(folder / "lock", "w")  # noqa: SIM115 closed by the with below
        except FileNotFoundError:
            continue  # taken away between the two lines
        with lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if still_there(folder / "lock", lock.fileno()):
                yield folder
                return


def leave(channel: str, own: Path) -> None:
    """Take our name away, and the folder after the last one."""
    own.unlink(missing_ok=True)
    with contextlib.suppress(OSError), alone(channel) as folder:
        if not any(folder.glob("*.sock")):
            (folder / "lock").unlink()
            folder.rmdir()


def listen(folder: Path) -> tuple[socket.socket, Path]:
    """A listening socket under a fresh name in the folder."""
    path = folder / f"{os.getpid()}-{secrets.token_hex(4)}.sock"
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    listener.bind(str(path))
    listener.listen(64)
    return listener, path


def connect_others(folder: Path, own: Path) -> Iterator[socket.socket]:
    """Connections to every other living node; names left behind by dead ones are removed."""
    for path in sorted(folder.glob("*.sock")):
        if path == own:
            continue
        peer = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            peer.connect(str(path))
        except ConnectionRefusedError:
            peer.close()
            path.unlink(missing_ok=True)
        except OSError:
            peer.close()
        else:
            yield peer
