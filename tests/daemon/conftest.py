"""A daemon with all its processes, as a user starts it."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import statistics
import subprocess
import sys
import time
from collections import defaultdict
from pathlib import Path

import pytest
from bus_observer import Observer
from small_arm import small_arm

from pa10d.client import Client, running_at
from pa10d.common.errors import UserError

START_MOVING = 300.0  # s from request to motion: on a busy machine planning takes long

REST = "seconds to rest"


class Bench:
    """``pa10d serve`` on a private bus with a virtual arm that outlives it."""

    def __init__(self, data: Path, channel: str, clock: str = "real") -> None:
        self.data, self.channel, self.clock = data, channel, clock
        few = clock == "simulated"  # joints, sooner computed; what passes by itself costs nothing
        self.arm = ["--profile", str(small_arm(data))] if few else []
        self.nodes = (1, 2, 4) if few else range(1, 8)
        self.messages: int | None = None  # where the daemon's go, by itself to those of the tests
        self.simulator: subprocess.Popen | None = None
        self.server: subprocess.Popen | None = None
        self._stack = contextlib.ExitStack()
        self.client: Client | None = None
        self.observer: Observer | None = None

    @property
    def goes_on_alone(self) -> bool:
        """Whether time passes for the drives while nobody sends SYNC."""
        return self.clock == "real"

    def start_simulator(self) -> None:
        options = ["sim", *self.arm, "--channel", self.channel, "--clock", self.clock]
        said = self.data / "simulator.log"  # a pipe that nobody reads would stop it once full
        with said.open("w") as log:
            self.simulator = subprocess.Popen(
                [sys.executable, "-m", "pa10d", *options], stderr=log, text=True
            )
        while "virtual arm on" not in said.read_text():
            assert self.simulator.poll() is None, said.read_text()
            time.sleep(0.05)
        self.observer = Observer(self.channel, self.nodes)

    def start_daemon(self) -> None:
        url = self.start_server()
        self.client = self._stack.enter_context(running_at(url, self.data))

    def start_server(self) -> str:
        """Its address; whether it reaches the robot is another matter."""
        options = ["--data", str(self.data), "--json", "serve", "--port", "0", "--no-sim"]
        options += [*self.arm, "--channel", self.channel, "--clock", self.clock]
        self.server = subprocess.Popen(
            [sys.executable, "-m", "pa10d", *options], stdout=subprocess.PIPE, text=True,
            stderr=self.messages,
        )  # fmt: skip
        return str(json.loads(self.server.stdout.readline())["url"])

    def pid_of(self, module: str) -> int:
        """The daemon's only child of this kind."""
        (pid,) = self.pids_of(module)
        return pid

    def pids_of(self, module: str) -> list[int]:
        """Children of the daemon."""
        found = []
        for path in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                words = (path / "cmdline").read_bytes().split(b"\0")
                parent = int((path / "stat").read_text().rpartition(")")[2].split()[1])
                if parent == self.server.pid and module.encode() in words:
                    found.append(int(path.name))
        return found

    def start_moving(self, seconds: float, cycles: int = 8) -> dict:
        """An experiment of 4 s per cycle whose arm has moved for this long."""
        plan = {"kind": "tracking", "parameters": {"period": 4.0, "cycles": cycles}}
        job = self.client.start("experiments", plan)
        until = time.monotonic() + START_MOVING
        while not self._moves():
            now = self.client.job(job["id"])
            assert now["status"] == "running", now.get("error") or now
            if time.monotonic() > until:
                self.client.cancel(job["id"])
                raise AssertionError(f"the arm does not move: {self.client.job(job['id'])}")
            time.sleep(0.02)
        time.sleep(seconds)
        return job

    def _moves(self) -> bool:
        robot = self.client.robot()
        return robot["recording"] and any(abs(a["velocity"]) > 0.05 for a in robot["axes"])

    def kill_simulator(self) -> None:
        self.simulator.kill()
        _close(self.simulator)
        self.observer.close()

    def kill_daemon(self) -> None:
        self.server.kill()
        _close(self.server)

    def tell_daemon_to_end(self) -> None:
        """As systemd does."""
        self.server.send_signal(signal.SIGTERM)

    def wait_for_its_end(self, seconds: float) -> None:
        """Until the daemon is gone."""
        self.server.wait(seconds)
        _close(self.server)

    def recover(self) -> None:
        """After a reset everything works again; an arm simulated anew stands elsewhere."""
        until = time.monotonic() + 90
        while (state := self.client.robot()["state"]) != "inactive":
            if state == "fault":
                with contextlib.suppress(UserError):  # it names what is still away
                    self.client.reset()
            elif state == "running":  # what a test that failed has left moving
                self.client.stop()
            elif state == "holding":
                self.client.disable()
            assert time.monotonic() < until, self.client.robot()
            time.sleep(0.2)
        self.client.confirm()

    def mend(self) -> None:
        """Start again what is dead."""
        if self.simulator.poll() is not None:
            self.start_simulator()
        if self.server.poll() is not None:
            self.start_daemon()

    def end(self) -> None:
        for process in (self.server, self.simulator):
            if process is not None and process.poll() is None:
                process.send_signal(signal.SIGTERM)
                try:
                    process.wait(20)
                except subprocess.TimeoutExpired:
                    process.kill()
            if process is not None:
                _close(process)
        self._stack.close()
        if self.observer is not None:
            self.observer.close()


def _close(process: subprocess.Popen) -> None:
    process.wait()
    for pipe in (process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()


CLOCKS = ["simulated", pytest.param("real", marks=[pytest.mark.long, pytest.mark.realtime])]


@pytest.fixture(scope="module", params=CLOCKS)
def bench(request, tmp_path_factory):
    """One for all tests of a module; they leave it inactive."""
    name = f"t{os.getpid()}-{time.time_ns() % 10**6}"
    made = Bench(tmp_path_factory.mktemp("data"), name, request.param)
    try:
        made.start_simulator()
        made.start_daemon()
        yield made
    finally:
        made.end()


@pytest.fixture
def data(bench):
    return bench.data


@pytest.fixture
def took_to_rest(request):
    """Note the s that the arm took; the end of the session tells median and most of them."""
    name = request.node.originalname
    return lambda seconds: request.node.user_properties.append((REST, (name, seconds)))


def pytest_terminal_summary(terminalreporter):
    """How soon the arm was at rest, per kind of test."""
    took = defaultdict(list)
    for report in terminalreporter.getreports("passed"):
        for key, value in report.user_properties:
            if key == REST and report.when == "call":
                took[value[0]].append(value[1])
    if took:
        terminalreporter.section("s to rest")
    for name, seconds in took.items():
        median, most = statistics.median(seconds), max(seconds)
        line = f"{name}: {len(seconds)} times, median {median:.2f}, most {most:.2f}"
        terminalreporter.write_line(line)
