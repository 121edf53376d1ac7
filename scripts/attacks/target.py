"""The daemon that is attacked, and how soon it stops the arm meanwhile."""

from __future__ import annotations

import contextlib
import http.client
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from pa10d.client import Client, local_daemon
from pa10d.store import Channels, RunStore, Samples

JOINTS = tuple("abcdefg")
Figures = dict[str, Any]


@dataclass(frozen=True)
class Effort:
    """How often to try: as often as asked for, else a share of what is usual."""

    share: float = 1.0
    trials: int | None = None
    only: str = "simulated"  # which of the tests that kill and suspend, as pytest's -k

    def times(self, usual: int) -> int:
        """How many trials."""
        return self.trials or max(min(usual, 3), round(usual * self.share))


class Target:
    """A daemon in simulated time, its data folder, and how often to try."""

    def __init__(self, client: Client, data: Path, effort: Effort) -> None:
        self.client, self.data, self.url = client, data, client.url
        self.times = effort.times
        self.host, port = client.url.removeprefix("http://").split(":")
        self.port = int(port)
        pid = json.loads((data / "daemon.json").read_text())["pid"]
        self.process = psutil.Process(pid)

    def held(self) -> Figures:
        """What the daemon and all its processes hold of the machine."""
        family = [self.process, *self.process.children(recursive=True)]
        return {
            "daemon_mb": round(self.process.memory_info().rss / 1e6),
            "all_mb": round(sum(_of(one, lambda p: p.memory_info().rss) for one in family) / 1e6),
            "processes": len(family),
            "descriptors": sum(_of(one, lambda p: p.num_fds()) for one in family),
            "sockets": sum(_of(one, _sockets) for one in family),
            "files": sum(1 for path in self.data.rglob("*") if path.is_file()),
        }


Trial = Callable[[Target], Figures]


def _of(process: psutil.Process, ask: Callable[[psutil.Process], int]) -> int:
    with contextlib.suppress(psutil.Error):
        return ask(process)
    return 0  # it has just ended


def _sockets(process: psutil.Process) -> int:
    links = Path(f"/proc/{process.pid}/fd").iterdir()
    return sum(_leads_to_socket(link) for link in links)


def _leads_to_socket(link: Path) -> bool:
    with contextlib.suppress(OSError):
        return str(link.readlink()).startswith("socket:")
    return False


@contextlib.contextmanager
def attacked(effort: Effort) -> Iterator[Target]:
    """One with a short run in its store, for all trials of a kind."""
    with tempfile.TemporaryDirectory() as place:
        data = Path(place)
        store_run(RunStore(data), "seed", 500)
        with local_daemon(data, clock="simulated") as client:
            client.wait_for_robot("inactive", timeout=120)
            yield Target(client, data, effort)


def stops(url: str, count: int) -> dict[str, float]:
    """``ask_to_stop`` from a process of its own, which nothing here disturbs."""
    command = [sys.executable, __file__, url, str(count)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def ask_to_stop(url: str, count: int, pause: float = 0.05) -> dict[str, float]:
    """POST /robot/stop on fresh connections → ms: median, 99 %, longest."""
    took = []
    for _ in range(count):
        began = time.perf_counter()
        one = http.client.HTTPConnection(*url.removeprefix("http://").split(":"), timeout=30)
        one.request("POST", "/api/v1/robot/stop")
        assert one.getresponse().status == 200
        one.close()
        took.append(1e3 * (time.perf_counter() - began))
        time.sleep(pause)
    return {
        "requests": count, "median": float(np.median(took)),
        "p99": float(np.quantile(took, 0.99)), "longest": float(np.max(took)),
    }  # fmt: skip


def samples(count: int, first: int) -> Samples:
    """Of an arm that swings, at 500 Hz, from sample ``first`` on."""
    rng = np.random.default_rng(first)
    stamps = 10**18 + (first + np.arange(count)) * 2_000_000
    q = 0.3 * np.sin(stamps[:, None] * 1e-9 * np.arange(1, 8))
    return Samples(stamps, q, 5 * q + 0.1 * rng.standard_normal((count, 7)))


def store_run(store: RunStore, name: str, count: int) -> None:
    """A whole run of ``count`` samples."""
    with store.building(name, name, Channels(JOINTS)) as writer:
        writer.append(samples(count, 0))


if __name__ == "__main__":
    print(json.dumps(ask_to_stop(sys.argv[1], int(sys.argv[2]))))
