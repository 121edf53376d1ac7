"""How long a diagnosis takes: whole library, 7 joints, 2 × 40 s to fit and 2 × 40 s to judge by.

From loaded runs to findings; simulating the arm and identifying the textbook model are not timed.
"""

from __future__ import annotations

import statistics
import time
from typing import Any

from backends.virtual.datasets import make_runs
from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import robot_from_profile
from pa10d.identify import identify
from pa10d.profile import load_profile

CASES: dict[str, list[dict[str, Any]]] = {
    "nothing hidden": [],
    "stribeck hidden in joint 4": [{"effect": "stribeck", "joint": 4, "Fs": 3.0, "vs": 0.08}],
}


def run(rounds: int = 3) -> dict[str, Any]:
    """Seconds per diagnosis (median of ``rounds``, after one that compiles), and what was found."""
    robot = robot_from_profile(load_profile("pa10-sim"))
    out: dict[str, Any] = {}
    for name, effects in CASES.items():
        runs, _ = make_runs(7, effects)
        fit, held = [runs["train_a"], runs["train_b"]], [runs["valid_a"], runs["valid_b"]]
        model = identify(fit, robot, name="bench")
        times, processor = [], []
        for number in range(rounds + 1):
            wall, cpu = time.perf_counter(), time.process_time()
            found = diagnose(model, fit, held)
            if number:
                times.append(time.perf_counter() - wall)
                processor.append(time.process_time() - cpu)
        out[name] = {
            "seconds": statistics.median(times),
            "processor_seconds": statistics.median(processor),
            "verdict": found.verdict,
            "found": [f.term.label for f in found.findings],
        }
    return out


def sentences(figures: dict[str, Any]) -> str:
    """For a person."""
    return "\n".join(
        f"{name}: {f['seconds']:.1f} s ({f['processor_seconds']:.1f} s of processor time), "
        f"verdict {f['verdict']} {', '.join(f['found'])}"
        for name, f in figures.items()
    )
