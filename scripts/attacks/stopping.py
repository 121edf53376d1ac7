"""How soon ``stop`` is answered, whatever else is asked of the daemon."""

from __future__ import annotations

import concurrent.futures
import contextlib
import logging
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import httpx
import psutil
from websockets.sync.client import connect

from attacks.target import Figures, Target, Trial, stops

HOLD = (
    "import fcntl, sys, time; f = open(sys.argv[1], 'a'); fcntl.flock(f, fcntl.LOCK_EX); "
    "print('held', flush=True); time.sleep(3600)"
)
CONNECTIONS, SLOW_READERS, FLOODING = 1000, 50, 4


def undisturbed(target: Target) -> Figures:
    """stop, with nothing else going on"""
    return {"stop_ms": stops(target.url, target.times(200))}


def locked_store(target: Target) -> Figures:
    """stop, while a suspended process holds the runs' lock and 20 clients change runs"""
    lock = target.data / "runs" / ".lock"
    holder = subprocess.Popen([sys.executable, "-c", HOLD, str(lock)], stdout=subprocess.PIPE)
    try:
        assert holder.stdout is not None
        holder.stdout.readline()
        holder.send_signal(signal.SIGSTOP)
        with concurrent.futures.ThreadPoolExecutor(20) as pool:
            change = [pool.submit(_change, target.url) for _ in range(20)]
            time.sleep(0.3)
            found = stops(target.url, target.times(60))
            answers = sorted({one.result() for one in change})
    finally:
        holder.kill()
        holder.wait()
        assert holder.stdout is not None
        holder.stdout.close()
    return {"stop_ms": found, "answers_to_the_changes": answers}


def _change(url: str) -> int:
    with httpx.Client(base_url=url, timeout=60, trust_env=False) as one:
        return one.patch("/api/v1/runs/seed", json={"tags": ["x"]}).status_code


def control_suspended(target: Target) -> Figures:
    """stop, while the control process stands still (it obeys as soon as it goes on)"""
    control = _control(target)
    control.suspend()
    try:
        return {"stop_ms": stops(target.url, target.times(60))}
    finally:
        control.resume()


def _control(target: Target) -> psutil.Process:
    return next(p for p in target.process.children() if "pa10d.control" in p.cmdline())


def busy_workers(target: Target) -> Figures:
    """stop, while every worker computes"""
    ask = {"kind": "excitation", "parameters": {"cycles": 30}}
    jobs = [target.client.start("experiments/check", ask) for _ in range(6)]
    found = stops(target.url, target.times(60))
    for job in jobs:
        target.client.cancel(job["id"])
    return {"stop_ms": found}


def connections(target: Target) -> Figures:
    """stop, with 1000 connections open and 50 of them reading nothing"""
    with contextlib.ExitStack() as stack:
        for k in range(CONNECTIONS):
            one = stack.enter_context(socket.create_connection((target.host, target.port), 30))
            if k < SLOW_READERS:  # they ask for much and take nothing
                request = f"GET /scripts/plotly.js HTTP/1.1\r\nHost: {target.host}\r\n\r\n"
                one.sendall(request.encode())
        found = stops(target.url, target.times(60))
    return {"connections": CONNECTIONS, "slow_readers": SLOW_READERS, "stop_ms": found}


def slow_listeners(target: Target) -> Figures:
    """stop, while 50 listen to the telemetry and never read"""
    address = target.url.replace("http", "ws") + "/api/v1/telemetry?history=600"
    before = target.process.memory_info().rss
    with contextlib.ExitStack() as stack:
        for _ in range(SLOW_READERS):
            stack.enter_context(_silent_listener(target, address))
        found = stops(target.url, target.times(60))
        grown = target.process.memory_info().rss - before
    return {"listeners": SLOW_READERS, "daemon_mb_more": round(grown / 1e6), "stop_ms": found}


def _silent_listener(target: Target, address: str) -> socket.socket:
    """The handshake of a WebSocket, and nothing after it."""
    one = socket.create_connection((target.host, target.port), 30)
    path = address.split("/", 3)[3]
    one.sendall(
        f"GET /{path} HTTP/1.1\r\nHost: {target.host}:{target.port}\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    return one


def messages(target: Target) -> Figures:
    """stop, while 4 clients send WebSocket messages as fast as they can"""
    return _flooded(target, lambda one: one.send("x" * 64))


def pings(target: Target) -> Figures:
    """stop, while 4 clients send WebSocket pings as fast as they can"""
    return _flooded(target, lambda one: one.ping())


def _flooded(target: Target, say: Callable[[Any], None]) -> Figures:
    over, sent = threading.Event(), []

    def flood() -> None:
        address = target.url.replace("http", "ws") + "/api/v1/events"
        count = 0
        while not over.is_set():
            with contextlib.suppress(Exception), connect(address, proxy=None) as one:
                while not over.is_set():
                    say(one)
                    count += 1
        sent.append(count)

    logging.getLogger("websockets").setLevel(logging.CRITICAL)  # being left is what it is about
    threads = [threading.Thread(target=flood, daemon=True) for _ in range(FLOODING)]
    for thread in threads:
        thread.start()
    time.sleep(0.5)
    found = stops(target.url, target.times(60))
    over.set()
    for thread in threads:
        thread.join(10)
    return {"sent": sum(sent), "stop_ms": found}


def stands_still(target: Target) -> Figures:
    """control stops by signal while the daemon stands still"""
    job = target.client.start("experiments", {"kind": "tracking", "parameters": {"cycles": 1000}})
    while target.client.robot()["state"] != "running":
        if target.client.job(job["id"])["status"] == "failed":
            return {"failed": target.client.job(job["id"])["error"]}
        time.sleep(0.02)
    target.process.suspend()
    os.kill(_control(target).pid, signal.SIGUSR1)
    time.sleep(1.0)
    target.process.resume()
    while (now := target.client.job(job["id"]))["status"] == "running":
        time.sleep(0.05)
    return {"job": now["error"]}


TRIALS: tuple[Trial, ...] = (
    undisturbed, locked_store, control_suspended, busy_workers, connections, slow_listeners,
    messages, pings, stands_still,
)  # fmt: skip
