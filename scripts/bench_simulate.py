"""How fast simulated time runs with frames on the bus: two processes, seven axes, no listeners.

The arm's process has drives and plant, this one the backend and a PD controller. Beside it, before
and after in the same run, the same frames between two processes that do nothing with them: machines
differ by a factor of three, ratios to that do not.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from ping_pong import ping_pong

from backends import by_hand
from backends.canopen_cia402.backend import CanopenBackend
from pa10d.profile import Profile, load_profile

if TYPE_CHECKING:
    from collections.abc import Iterator

    from backends.protocol import Array, Feedback


@contextmanager
def arm_process(profile: Profile, channel: str) -> Iterator[None]:
    """The virtual arm in simulated time on a bus of its own."""
    command = [sys.executable, "-m", "backends.virtual", str(profile.path)]
    process = subprocess.Popen(
        [*command, "--channel", channel, "--clock", "simulated"],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        if process.stdout.readline() != "ready\n":
            raise SystemExit("the virtual arm did not start")
        yield
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(10)


class PdController:
    """Holds the pose against gravity; stiff enough to keep the arm where it is."""

    def __init__(self, profile: Profile, period: float) -> None:
        rated = np.array([d.rated_torque * d.gear_ratio for d in profile.drives or []])
        self._kp, self._kd, self._period = 5.0 * rated, 0.3 * rated, period
        self._last: Array | None = None

    def torque(self, feedback: Feedback) -> Array:
        last = feedback.q if self._last is None else self._last
        speed = (feedback.q - last) / self._period
        self._last = feedback.q.copy()
        return -self._kp * feedback.q - self._kd * speed


def run(profile_name: str = "pa10-sim", cycles: int = 5000) -> dict[str, object]:
    """Cycles against the wall clock, and the processor time of the exchange alone (µs, median)."""
    profile = load_profile(profile_name)
    nodes = [drive.node for drive in profile.drives or []]
    bare = [ping_pong(nodes, cycles)]
    channel = f"bench-{os.getpid()}"
    can = profile.can.model_copy(update={"channel": channel})
    assert profile.simulation is not None
    simulation = profile.simulation.model_copy(update={"clock": "simulated"})
    profile = profile.model_copy(update={"can": can, "simulation": simulation})
    with arm_process(profile, channel):
        arm = CanopenBackend(profile)
        arm.open()
        try:
            control = PdController(profile, arm.period)
            by_hand.enable(arm, control.torque)
            exchange = np.empty(cycles)
            started = time.perf_counter()
            for k in range(cycles):
                t0 = time.thread_time_ns()
                feedback = arm.read()
                t1 = time.thread_time_ns()
                torque = control.torque(feedback)
                t2 = time.thread_time_ns()
                arm.write(torque)
                exchange[k] = t1 - t0 + time.thread_time_ns() - t2
            elapsed = time.perf_counter() - started
        finally:
            arm.close()
    bare.append(ping_pong(nodes, cycles))
    wall, processor = np.mean(bare, axis=0)
    cycle, own = 1e6 * elapsed / cycles, float(np.median(exchange)) / 1000
    return {
        "axes": arm.n,
        "rate_hz": profile.control.rate,
        "cycles": cycles,
        "times_real_time": round(cycles * arm.period / elapsed, 2),
        "cycle_us": round(cycle, 1),
        "bare_cycle_us": round(float(wall), 1),
        "cycle_times_bare": round(cycle / float(wall), 1),
        "exchange_cpu_us_median": round(own, 1),
        "bare_cpu_us_median": round(float(processor), 1),
        "exchange_times_bare": round(own / float(processor), 2),
        "exchange_cpu_us_p99": round(float(np.quantile(exchange, 0.99)) / 1000, 1),
        "listeners": 0,
        "plant": profile.simulation.plant if profile.simulation else None,
    }


def sentences(figures: dict[str, object]) -> str:
    """The figures for people."""
    return (
        f"{figures['axes']} axes at {figures['rate_hz']} Hz, frames on the bus, two processes: "
        f"{figures['times_real_time']} x real time ({figures['cycle_us']} us a cycle); "
        f"exchange {figures['exchange_cpu_us_median']} us of processor time a cycle (median)\n"
        f"the same frames between two processes that do nothing with them: "
        f"{figures['bare_cycle_us']} us a cycle ({figures['cycle_times_bare']} times as long with "
        f"arm and control), {figures['bare_cpu_us_median']} us of processor time "
        f"(exchange: {figures['exchange_times_bare']} times)"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--profile", default="pa10-sim")
    parser.add_argument("--cycles", type=int, default=5000)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    figures = run(given.profile, given.cycles)
    print(json.dumps(figures) if given.json else sentences(figures))


if __name__ == "__main__":
    main()
