"""What a daemon in simulated time stands up to, measured → docs/reliability.md.

python scripts/reliability.py [--quick] [--json] [--write]: about a quarter of an hour; --quick a
tenth of everything. What runs in the test suite instead is named there.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import contextlib
import http.client
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import psutil
from websockets.sync.client import connect

from pa10d.client import Client, local_daemon
from pa10d.store import Channels, RunStore, Samples

ROOT = Path(__file__).resolve().parents[1]
JOINTS = tuple("abcdefg")
HOLD = (
    "import fcntl, sys, time; f = open(sys.argv[1], 'a'); fcntl.flock(f, fcntl.LOCK_EX); "
    "print('held', flush=True); time.sleep(3600)"
)


def stops(url: str, count: int) -> dict[str, float]:
    """``ask_to_stop`` from a process of its own, which nothing here disturbs."""
    command = [sys.executable, __file__, "--stops", url, str(count)]
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
        "median": float(np.median(took)), "p99": float(np.quantile(took, 0.99)),
        "longest": float(np.max(took)),
    }  # fmt: skip


class Bench:
    """A daemon, its data folder, and how often to try."""

    def __init__(self, client: Client, data: Path, scale: float) -> None:
        self.client, self.data, self.url, self.scale = client, data, client.url, scale
        self.host, port = client.url.removeprefix("http://").split(":")
        self.port = int(port)
        pid = json.loads((data / "daemon.json").read_text())["pid"]
        self.process = psutil.Process(pid)

    def times(self, count: int) -> int:
        return max(3, round(count * self.scale))

    def held(self) -> dict[str, float]:
        """Of the daemon and all its processes."""
        family = [self.process, *self.process.children(recursive=True)]
        rss = 0
        for one in family:
            with contextlib.suppress(psutil.Error):
                rss += one.memory_info().rss
        return {
            "daemon_mb": self.process.memory_info().rss / 1e6, "all_mb": rss / 1e6,
            "processes": len(family), "descriptors": self.process.num_fds(),
        }  # fmt: skip


def undisturbed(bench: Bench) -> dict[str, Any]:
    """stop, with nothing else going on"""
    return {"stop_ms": stops(bench.url, bench.times(200))}


def locked_store(bench: Bench) -> dict[str, Any]:
    """stop, while a suspended process holds the runs' lock and 20 clients change runs"""
    lock = bench.data / "runs" / ".lock"
    holder = subprocess.Popen([sys.executable, "-c", HOLD, str(lock)], stdout=subprocess.PIPE)
    try:
        holder.stdout.readline()
        holder.send_signal(signal.SIGSTOP)
        with concurrent.futures.ThreadPoolExecutor(20) as pool:
            change = [pool.submit(_change, bench.url) for _ in range(20)]
            time.sleep(0.3)
            found = stops(bench.url, bench.times(60))
            answers = sorted({one.result() for one in change})
    finally:
        holder.kill()
        holder.wait()
        holder.stdout.close()
    return {"stop_ms": found, "answers_to_the_changes": answers}


def _change(url: str) -> int:
    with httpx.Client(base_url=url, timeout=60, trust_env=False) as one:
        return one.patch("/api/v1/runs/seed", json={"tags": ["x"]}).status_code


def busy_workers(bench: Bench) -> dict[str, Any]:
    """stop, while every worker computes"""
    ask = {"kind": "excitation", "parameters": {"cycles": 30}}
    jobs = [bench.client.start("experiments/check", ask) for _ in range(6)]
    found = stops(bench.url, bench.times(60))
    for job in jobs:
        bench.client.cancel(job["id"])
    return {"stop_ms": found}


def connections(bench: Bench) -> dict[str, Any]:
    """stop, with 1000 connections open and 50 of them reading nothing"""
    open_ = []
    try:
        for k in range(1000):
            one = socket.create_connection((bench.host, bench.port), timeout=30)
            open_.append(one)
            if k < 50:  # slow readers: ask for much, take nothing
                request = f"GET /scripts/plotly.js HTTP/1.1\r\nHost: {bench.host}\r\n\r\n"
                one.sendall(request.encode())
        found = stops(bench.url, bench.times(60))
    finally:
        for one in open_:
            one.close()
    return {"connections": len(open_), "stop_ms": found}


def flood(bench: Bench) -> dict[str, Any]:
    """stop, while 4 clients send WebSocket messages as fast as they can"""
    over, sent = threading.Event(), []

    def send() -> None:
        address = bench.url.replace("http", "ws") + "/api/v1/events"
        count = 0
        while not over.is_set():
            with contextlib.suppress(Exception), connect(address, proxy=None) as one:
                while not over.is_set():
                    one.send("x" * 64)
                    count += 1
        sent.append(count)

    threads = [threading.Thread(target=send, daemon=True) for _ in range(4)]
    for thread in threads:
        thread.start()
    time.sleep(0.5)
    found = stops(bench.url, bench.times(60))
    over.set()
    for thread in threads:
        thread.join(10)
    return {"messages": sum(sent), "stop_ms": found}


def many_jobs(bench: Bench) -> dict[str, Any]:
    """2000 jobs: memory, processes and files before and after"""
    count = bench.times(2000)
    ask = {"kind": "tracking", "parameters": {"cycles": 1}}
    with httpx.Client(base_url=bench.url, timeout=60, trust_env=False) as one:
        _jobs(one, ask, 100)
        before = bench.held()
        began = time.monotonic()
        refused = _jobs(one, ask, count)
        seconds = time.monotonic() - began
    return {
        "jobs": count,
        "seconds": seconds,
        "told_to_wait": refused,
        "before": before,
        "after": bench.held(),
    }


def _jobs(one: httpx.Client, ask: Any, count: int) -> int:
    """Start and cancel them, as impatient clients do, one in twenty to its end."""
    refused = 0
    for k in range(count):
        while (answer := one.post("/api/v1/experiments/check", json=ask)).status_code == 429:
            refused += 1
            time.sleep(0.2)
        job = answer.json()["id"]
        if k % 20:
            one.post(f"/api/v1/jobs/{job}/cancel")
        else:
            while one.get(f"/api/v1/jobs/{job}").json()["status"] in ("queued", "running"):
                time.sleep(0.05)
    return refused


def one_name_twice(bench: Bench) -> dict[str, Any]:
    """imports of one name at the same time: one is stored"""
    t = np.arange(400) * 0.002
    names = [f"{f}{j}" for f in ("q", "tau") for j in range(1, 8)]
    rows = "\n".join(",".join([f"{s:.3f}", *["0.1"] * 14]) for s in t)
    body = ",".join(["time", *names]) + "\n" + rows + "\n"
    rounds, codes = bench.times(20), []
    for k in range(rounds):
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            path = f"{bench.url}/api/v1/runs?name=twin-{k}"
            sent = [pool.submit(httpx.post, path, content=body, timeout=60) for _ in range(2)]
            codes.append(sorted(one.result().status_code for one in sent))
    return {"rounds": rounds, "answers": sorted({str(pair) for pair in codes})}


def deleted_while_analysed(bench: Bench) -> dict[str, Any]:
    """runs deleted while a model is fitted to them: the job says so, nothing else happens"""
    said: dict[str, int] = {}
    rounds = bench.times(20)
    for k in range(rounds):
        store = RunStore(bench.data)
        _store_run(store, f"short-lived-{k}", 4000)
        ask = {"runs": [f"short-lived-{k}"], "name": f"m-{k}", "replace": True}
        job = bench.client.start("models", ask)
        time.sleep(0.02 * k)
        httpx.delete(f"{bench.url}/api/v1/runs/short-lived-{k}", timeout=30)
        while (now := bench.client.job(job["id"]))["status"] in ("queued", "running"):
            time.sleep(0.05)
        kind = "fitted" if now["status"] == "succeeded" else "told"
        if "Error" in (now["error"] or "")[:20]:
            kind = f"bug: {now['error'][:80]}"
        said[kind] = said.get(kind, 0) + 1
    return {"rounds": rounds, "ended": said}


def read_only(bench: Bench) -> dict[str, Any]:
    """a data folder that cannot be written (one line each)"""
    with tempfile.TemporaryDirectory() as place:
        command = ["mount", "-t", "tmpfs", "-o", "ro,size=1m", "none", place]
        if subprocess.run(command, capture_output=True, check=False).returncode:
            return {"skipped": "needs the right to mount a file system"}
        try:
            done = subprocess.run(
                [sys.executable, "-m", "pa10d", "--data", place, "run", "list"],
                capture_output=True, text=True, check=False,
            )  # fmt: skip
        finally:
            subprocess.run(["umount", place], check=True)
    return {"status": done.returncode, "lines": len(done.stderr.strip().splitlines()),
            "said": done.stderr.strip().replace(place, "DATA")}  # fmt: skip


def full_disk(bench: Bench) -> dict[str, Any]:
    """a disk of 64 MB that fills up: what the run is told, and what is left of it"""
    with tempfile.TemporaryDirectory() as place:
        command = ["mount", "-t", "tmpfs", "-o", "size=64m", "none", place]
        if subprocess.run(command, capture_output=True, check=False).returncode:
            return {"skipped": "needs the right to mount a file system"}
        try:
            store = RunStore(place)
            writer = store.start("filled", Channels(JOINTS))
            given = 0
            try:
                while True:
                    writer.append(_samples(2000, given))
                    writer.flush()
                    given += 2000
            except OSError as error:
                info = writer.salvage(f"{error.strerror} while recording")
            read = len(RunStore(place).read("filled").samples)
            refused = ""
            try:
                store.start("next", Channels(JOINTS), samples=100_000)
            except Exception as error:
                refused = str(error).replace(place, "DATA")
        finally:
            subprocess.run(["umount", place], check=True)
    return {"status": info.status, "reason": info.reason, "written": given, "readable": read,
            "the_next_is_told": refused}  # fmt: skip


def stands_still(bench: Bench) -> dict[str, Any]:
    """control stops by signal while the daemon stands still"""
    (control,) = [child for child in bench.process.children() if "pa10d.control" in child.cmdline()]
    job = bench.client.start("experiments", {"kind": "tracking", "parameters": {"cycles": 1000}})
    while bench.client.robot()["state"] != "running":
        if bench.client.job(job["id"])["status"] == "failed":
            return {"failed": bench.client.job(job["id"])["error"]}
        time.sleep(0.02)
    bench.process.suspend()
    os.kill(control.pid, signal.SIGUSR1)
    time.sleep(1.0)
    bench.process.resume()
    while (now := bench.client.job(job["id"]))["status"] == "running":
        time.sleep(0.05)
    return {"job": now["error"]}


def _samples(count: int, first: int) -> Samples:
    rng = np.random.default_rng(first)
    stamps = 10**18 + (first + np.arange(count)) * 2_000_000
    q = 0.3 * np.sin(stamps[:, None] * 1e-9 * np.arange(1, 8))
    return Samples(stamps, q, 5 * q + 0.1 * rng.standard_normal((count, 7)))


def _store_run(store: RunStore, name: str, count: int) -> None:
    with store.building(name, name, Channels(JOINTS)) as writer:
        writer.append(_samples(count, 0))


TRIALS: tuple[Callable[[Bench], dict[str, Any]], ...] = (
    undisturbed, locked_store, busy_workers, connections, flood, one_name_twice,
    deleted_while_analysed, stands_still, full_disk, read_only, many_jobs,
)  # fmt: skip


@contextlib.contextmanager
def _bench(scale: float) -> Iterator[Bench]:
    with tempfile.TemporaryDirectory() as place:
        data = Path(place)
        _store_run(RunStore(data), "seed", 500)
        with local_daemon(data, clock="simulated") as client:
            client.wait_for_robot("inactive", timeout=120)
            yield Bench(client, data, scale)


def page(found: dict[str, Any]) -> str:
    """The figures as a page."""
    lines = [
        "# Reliability", "",
        "Made by `python scripts/reliability.py --write`: a daemon in simulated time, attacked. "
        "The aim: `stop` is answered within 100 ms whatever the store, the workers or a client do, "
        "on a machine that does nothing else. Each time is one request on a connection of "
        "its own, without waiting for the arm's rest (`?wait=SECONDS` does).", "",
        f"Machine: {os.cpu_count()} processors, load {os.getloadavg()[1]:.1f} while this ran.", "",
        "| while … | stop, median ms | 99 % | longest | besides |", "|---|---|---|---|---|",
    ]  # fmt: skip
    for entry in found.values():
        if "stop_ms" in entry:
            ms = entry["stop_ms"]
            more = ", ".join(
                f"{k.replace('_', ' ')}: {v}"
                for k, v in entry.items()
                if k[:4] not in ("stop", "what")
            )
            what = entry["what"].removeprefix("stop, ").removeprefix("while ")
            lines.append(
                f"| {what} | {ms['median']:.0f} | {ms['p99']:.0f} | {ms['longest']:.0f} | {more} |"
            )
    lines.append("")
    for entry in found.values():
        if "stop_ms" not in entry:
            lines += [f"- **{entry['what']}**: " + "; ".join(_told(entry))]
    lines += ["", OTHERS]
    return "\n".join(lines)


def _told(entry: dict[str, Any]) -> Iterator[str]:
    for key, value in entry.items():
        if key == "what":
            continue
        shown = value
        if isinstance(value, dict):
            shown = ", ".join(
                f"{k} {v:.0f}" if isinstance(v, float) else f"{k} {v}" for k, v in value.items()
            )
        elif isinstance(value, float):
            shown = f"{value:.0f}"
        yield f"{key.replace('_', ' ')}: {shown}"


OTHERS = """## The second way to stop

`stop` needs the daemon. Where that does not answer, a signal to the control process does the same:
the arm comes to rest along its limits and is held.

```sh
pkill -USR1 -f pa10d.control              # from any terminal
systemctl kill --signal=USR1 pa10d        # as a service: all others ignore it
```

`SIGTERM` to control brings the arm to rest, closes the brakes and takes the power off.

## In the test suite

`scripts/test --long` kills each process 100 times in motion, damages 3200 files (bags, descriptions
of runs, models, profiles, URDFs, CSV; each is read or refused in one line), and asks 5760 requests
that schemathesis draws from all operations (no answer of 500 and above but those documented, every
answer as its schema says). The default suite holds a small share of each.

## Budgets

A job may take half of the machine's memory (at least 1, at most 8 GiB; `PA10D_JOB_MEMORY` in MiB
says otherwise) and an hour; what a request waits for, two minutes, in processes of its own. 64 jobs
are taken on at a time, the next one is told to wait (429). A compressed recording may grow
two-hundredfold, a recording at equal steps twentyfold. A run begins only where the disk has room
for its plan.
"""


def main() -> None:
    """All trials, or those named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trials", nargs="*", help="some of them (default: all)")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--write", action="store_true", help="docs/reliability.md")
    parser.add_argument("--stops", nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.stops:
        print(json.dumps(ask_to_stop(given.stops[0], int(given.stops[1]))))
        return
    found: dict[str, Any] = {}
    with _bench(0.1 if given.quick else 1.0) as bench:
        for trial in TRIALS:
            if given.trials and trial.__name__ not in given.trials:
                continue
            print(f"{trial.__name__} …", file=sys.stderr, flush=True)
            what = " ".join((trial.__doc__ or "").split())
            found[trial.__name__] = {"what": what, **trial(bench)}
            print(json.dumps(found[trial.__name__]), file=sys.stderr, flush=True)
    if given.write:
        (ROOT / "docs" / "reliability.md").write_text(page(found), encoding="utf-8")
    print(json.dumps(found, indent=1) if given.json else page(found))


if __name__ == "__main__":
    main()
