"""What the store stands up to: others who write, delete or fill the disk meanwhile."""

from __future__ import annotations

import concurrent.futures
import contextlib
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import numpy as np

from attacks.target import JOINTS, Figures, Target, Trial, samples, store_run
from pa10d.client import JobFailed, local_daemon
from pa10d.common.errors import UserError
from pa10d.store import Channels, RunStore

NO_MOUNT = {"skipped": "needs the right to mount a file system"}


def one_name_twice(target: Target) -> Figures:
    """imports of one name at the same time: one is stored"""
    t = np.arange(400) * 0.002
    names = [f"{f}{j}" for f in ("q", "tau") for j in range(1, 8)]
    rows = "\n".join(",".join([f"{s:.3f}", *["0.1"] * 14]) for s in t)
    body = ",".join(["time", *names]) + "\n" + rows + "\n"
    rounds, codes = target.times(20), []
    for k in range(rounds):
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            path = f"{target.url}/api/v1/runs?name=twin-{k}"
            sent = [pool.submit(httpx.post, path, content=body, timeout=60) for _ in range(2)]
            codes.append(sorted(one.result().status_code for one in sent))
    return {"rounds": rounds, "answers": sorted({str(pair) for pair in codes})}


def deleted_while_analysed(target: Target) -> Figures:
    """runs deleted while a model is fitted to them: the job says so, nothing else happens"""
    said: dict[str, int] = {}
    rounds = target.times(20)
    for k in range(rounds):
        store_run(RunStore(target.data), f"short-lived-{k}", 4000)
        ask = {"runs": [f"short-lived-{k}"], "name": f"m-{k}", "replace": True}
        job = target.client.start("models", ask)
        time.sleep(0.02 * k)
        httpx.delete(f"{target.url}/api/v1/runs/short-lived-{k}", timeout=30)
        while (now := target.client.job(job["id"]))["status"] in ("queued", "running"):
            time.sleep(0.05)
        kind = "fitted" if now["status"] == "succeeded" else "told"
        if "Error" in (now["error"] or "")[:20]:
            kind = f"bug: {now['error'][:80]}"
        said[kind] = said.get(kind, 0) + 1
    return {"rounds": rounds, "ended": said}


def read_only(target: Target) -> Figures:
    """a data folder that cannot be written (one line each)"""
    with _mounted("ro,size=1m") as place:
        if place is None:
            return NO_MOUNT
        command = [sys.executable, "-m", "pa10d", "--data", str(place)]
        said = {}
        for words in (["run", "list"], ["serve", "--port", "0"]):
            done = subprocess.run([*command, *words], capture_output=True, text=True, check=False)
            lines = done.stderr.strip().splitlines()
            last = lines[-1].replace(str(place), "DATA") if lines else "nothing"
            said[words[0]] = f"status {done.returncode}, {len(lines)} line: {last}"
    return said


def full_disk(target: Target) -> Figures:
    """a disk of 64 MB that fills up: what the run is told, and what is left of it"""
    with _mounted("size=64m") as place:
        if place is None:
            return NO_MOUNT
        store = RunStore(place)
        writer = store.start("filled", Channels(JOINTS))
        given = 0
        try:
            while True:
                writer.append(samples(2000, given))
                writer.flush()
                given += 2000
        except OSError as error:
            info = writer.salvage(f"{error.strerror} while recording")
        read = len(RunStore(place).read("filled").samples)
        refused = ""
        try:
            store.start("next", Channels(JOINTS), samples=100_000)
        except UserError as error:
            refused = str(error).replace(str(place), "DATA")
    return {"status": info.status, "reason": info.reason, "written": given, "readable": read,
            "the_next_is_told": refused}  # fmt: skip


def full_disk_in_motion(target: Target) -> Figures:
    """a disk that somebody else fills while the arm moves: the motion ends, and says why"""
    ended: dict[str, int] = {}
    rounds = target.times(3)
    for _ in range(rounds):
        with _mounted("size=256m") as place:
            if place is None:
                return NO_MOUNT
            how = _fill_while_moving(place)
        ended[how] = ended.get(how, 0) + 1
    return {"rounds": rounds, "ended": ended}


def _fill_while_moving(place: Path) -> str:
    """How the run ended, and whether the arm can be used again once there is room."""
    with local_daemon(place, clock="simulated") as client:
        plan = {"kind": "tracking", "parameters": {"period": 4.0, "cycles": 40}}
        job = client.start("experiments", plan)
        while not client.robot()["recording"]:
            if client.job(job["id"])["status"] == "failed":
                return f"never moved: {client.job(job['id'])['error']}"
            time.sleep(0.05)
        with contextlib.suppress(OSError), (place / "others").open("wb", buffering=0) as others:
            while True:
                others.write(bytes(1 << 20))
        try:
            client.wait(job)
            how = "the motion went to its end"
        except JobFailed as error:
            how = str(error)
        run = RunStore(place).all()[-1]
        readable = len(RunStore(place).read(run.id).samples) > 0
        state = client.wait_for_robot("inactive", "holding", "fault")["state"]
        (place / "others").unlink()
        again = client.experiment("tracking", {"period": 4.0, "cycles": 1})
        held = "readable" if readable else "unreadable"
        said = " ".join(how.replace(run.name, "NAME").split())
        return f"{run.status}, {held}, arm {state}, next run {_status(again)}; said: {said}"


def _status(result: Figures) -> str:
    return str(result["recorded"][0]["status"])


@contextlib.contextmanager
def _mounted(options: str) -> Iterator[Path | None]:
    """A small file system, None where that is not allowed."""
    with tempfile.TemporaryDirectory() as place:
        command = ["mount", "-t", "tmpfs", "-o", options, "none", place]
        if subprocess.run(command, capture_output=True, check=False).returncode:
            yield None
            return
        try:
            yield Path(place)
        finally:
            subprocess.run(["umount", "--lazy", place], check=True)


TRIALS: tuple[Trial, ...] = (
    one_name_twice, deleted_while_analysed, read_only, full_disk, full_disk_in_motion,
)  # fmt: skip
