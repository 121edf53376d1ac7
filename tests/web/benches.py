"""Daemons that the page is tried on."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def served(data: Path, channel: str, *options: str) -> Iterator[str]:
    """``pa10d serve`` without an arm: its address."""
    with _serving(data, channel, "--no-sim", *options) as url:
        yield url


@contextlib.contextmanager
def served_arm(data: Path, channel: str, *options: str) -> Iterator[str]:
    """``pa10d serve`` with a virtual arm in simulated time: its address."""
    with _serving(data, channel, "--clock", "simulated", *options) as url:
        yield url


@contextlib.contextmanager
def _serving(data: Path, channel: str, *options: str) -> Iterator[str]:
    command = [sys.executable, "-m", "pa10d", "--data", str(data), "--json", "serve"]
    command += ["--port", "0", "--channel", channel, *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        yield json.loads(process.stdout.readline())["url"]
    finally:
        process.terminate()
        process.wait(30)
        process.stdout.close()


def children_of(pid: int, module: str) -> list[int]:
    """Processes that this one has started with ``python -m module``."""
    asked = subprocess.run(["pgrep", "-P", str(pid), "-f", module], capture_output=True, text=True)
    return [int(one) for one in asked.stdout.split()]
