"""``python -m backends.virtual PROFILE``, forked from a process that has loaded what that needs.

Half of what a test on the bus computes would be the loading.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from multiprocessing.connection import Connection
from pathlib import Path

from backends.virtual.__main__ import main

_FORKING = multiprocessing.get_context("forkserver")
_FORKING.set_forkserver_preload(["backends.virtual.__main__"])


def _serve(profile: str, says: Connection) -> None:
    os.dup2(says.fileno(), sys.stdout.fileno())
    sys.argv = ["backends.virtual", profile]
    sys.exit(main())


class ForkedArm:
    """Has begun to serve; what it says is in ``stdout``."""

    def __init__(self, profile: Path) -> None:
        hears, says = _FORKING.Pipe(duplex=False)
        self._process = _FORKING.Process(target=_serve, args=(str(profile), says), daemon=True)
        self._process.start()
        says.close()
        self.stdout = os.fdopen(os.dup(hears.fileno()), encoding="utf-8")
        hears.close()
        assert self._process.pid is not None
        self.pid = self._process.pid

    def send_signal(self, number: int) -> None:
        if self._process.is_alive():
            os.kill(self.pid, number)

    def kill(self) -> None:
        self._process.kill()

    def end(self, patience: float = 5.0) -> None:
        """Waited for, as politely as it lets itself be."""
        self.send_signal(signal.SIGCONT)
        self._process.terminate()
        self._process.join(patience)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._process.close()
        self.stdout.close()
