"""The control loop under load, and a bare timer loop in turn with it under the same load.

Seven axes at 500 Hz over the virtual CAN bus in real time, computed torque with an identified
model, the run being recorded, 20 telemetry listeners and requests all the while. Processor time is
the control thread's own; a deadline is missed where a cycle was not finished within its period.
"""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.client import Client, JobFailed, local_daemon
from pa10d.control.ring import Ring
from pa10d.daemon.presence import present
from pa10d.daemon.processes.runtime import ring_of

RATE, PERIOD = 500.0, 4.0  # Hz; s of the sine that is tracked
SIGNIFICANT = 0.05
HERE = Path(__file__).resolve().parent
BARE = """
import json, sys
from pa10d.control.clock import Clock
from pa10d.control.realtime import prepare
prepare()
clock = Clock(1 / float(sys.argv[1]))
late = []
for _ in range(int(sys.argv[2])):
    clock.wait(True)
    clock.done()
    late.append(clock.late)
print(json.dumps({"late": late, "missed": clock.missed}))
"""


def run(rounds: int = 8, cycles: int = 3, profile: str = "pa10-sim") -> dict[str, Any]:
    """``rounds`` times: ``cycles`` sines of 4 s, then the bare loop for as long."""
    with tempfile.TemporaryDirectory() as data:
        with local_daemon(data, profile, clock="simulated") as client:
            runs = client.experiment("excitation")["runs"]
            client.identify(runs, "identified")
        with local_daemon(data, profile) as client:
            return _measure(client, Path(data), rounds, cycles)


def _measure(client: Client, data: Path, rounds: int, cycles: int) -> dict[str, Any]:
    found = present(data)
    assert found is not None
    ring = Ring.attach(ring_of(found.pid))
    load = subprocess.Popen([sys.executable, str(HERE / "bench_load.py"), client.url])
    loops, bare_late, bare_missed, recorded, broken = [], [], [], 0, []
    try:
        while len(loops) < rounds:
            k, before = len(loops) + len(broken), ring.written
            try:
                client.experiment(
                    "tracking", {"period": PERIOD, "cycles": cycles}, name=f"bench{k}",
                    controller="computed_torque", model="identified",
                )  # fmt: skip
            except JobFailed as failed:  # the machine stood still for longer than drives wait
                broken.append(str(failed))
                if len(broken) > rounds:
                    raise
                client.reset()
                client.wait_for_robot("inactive")
                continue
            rows, _ = ring.read(before)
            mine = rows[ring.layout.get(rows, "recording") > 0]
            loops.append(mine)
            recorded += client.run(f"bench{k}")["samples"]
            client._ask("POST", "/api/v1/robot/disconnect")
            count = len(mine)
            spoken = subprocess.run(
                [sys.executable, "-c", BARE, str(RATE), str(count)], check=True,
                capture_output=True, text=True,
            )  # fmt: skip
            bare = json.loads(spoken.stdout)
            bare_late += bare["late"]
            bare_missed.append(bare["missed"] / count)
            client._ask("POST", "/api/v1/robot/connect")
            client.wait_for_robot("inactive")
    finally:
        load.terminate()
        load.wait()
    figures = _figures(ring, loops, np.array(bare_late), np.array(bare_missed), recorded)
    return figures | {"broken_off": broken}


def _figures(
    ring: Ring, loops: list[Any], bare_late: Any, bare_missed: Any, recorded: int
) -> dict[str, Any]:
    get = ring.layout.get
    late = np.concatenate([get(rows, "late") for rows in loops])
    busy = np.concatenate([get(rows, "busy") for rows in loops])
    counts = np.array([np.ptp(get(rows, "missed")) for rows in loops])
    missed = counts / [len(rows) for rows in loops]
    return {
        "axes": ring.layout.n,
        "rate_hz": RATE,
        "cycles": len(late),
        "busy_us": {"median": _us(busy, 50), "p99": _us(busy, 99), "max": _us(busy, 100)},
        "late_us": {"median": _us(late, 50), "p99": _us(late, 99), "max": _us(late, 100)},
        "rounds": len(loops),
        "missed_share": float(missed.mean()),
        "missed_by_round": missed.tolist(),
        "bare_late_us": {
            "median": _us(bare_late, 50), "p99": _us(bare_late, 99), "max": _us(bare_late, 100),
        },
        "bare_missed_share": float(bare_missed.mean()),
        "bare_missed_by_round": bare_missed.tolist(),
        "p_value": paired_p_value(missed - bare_missed),
        "recorded": recorded,
        "lost": len(late) - recorded,
    }  # fmt: skip


def paired_p_value(differences: Any) -> float:
    """Chance of a mean as large as this one if each round's difference had either sign.

    One-sided, exact. Misses come in bursts, so that rounds are compared and not cycles.
    """
    signs = np.array(list(itertools.product((1, -1), repeat=len(differences))))
    means = signs @ differences
    return float(np.mean(means >= means[0] - 1e-12))


def _us(values: Any, percent: float) -> float:
    return round(1e6 * float(np.percentile(values, percent)), 1)


def sentences(figures: dict[str, Any]) -> str:
    """For a person."""
    worse = figures["p_value"] < SIGNIFICANT
    verdict = "significantly more" if worse else "not significantly more"
    f, busy, late, bare = figures, figures["busy_us"], figures["late_us"], figures["bare_late_us"]
    return "\n".join(
        [
            f"{f['axes']} axes at {f['rate_hz']:g} Hz, computed torque, recorded, 20 listeners: "
            f"{f['cycles']} cycles",
            f"processor time of the control thread per cycle: median {busy['median']:.0f} µs, "
            f"99 % {busy['p99']:.0f} µs (goal: median at most 300 µs)",
            f"a cycle begins {late['median']:.0f} µs late, 99 % {late['p99']:.0f} µs, "
            f"at most {late['max']:.0f} µs",
            f"the bare loop {bare['median']:.0f} µs, 99 % {bare['p99']:.0f} µs, "
            f"at most {bare['max']:.0f} µs",
            f"not done in time: {100 * f['missed_share']:.3f} % of the cycles, bare loop "
            f"{100 * f['bare_missed_share']:.3f} %; {verdict} (one-sided p = {f['p_value']:.2g}, "
            f"signs of the differences in {f['rounds']} alternating rounds)",
            f"{f['recorded']} samples recorded, {f['lost']} lost",
            *(f"a round was broken off and repeated: {why}" for why in f["broken_off"]),
        ]
    )
