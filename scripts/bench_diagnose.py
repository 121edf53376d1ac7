"""How long a diagnosis takes: whole library, 7 joints, 2 × 40 s to fit and 2 × 40 s to judge by.

From loaded runs to findings; simulating the arm and identifying the textbook model are not timed.
Beside it, in the same run, one factorisation of the fit side's matrix (all columns of the given
model and the torque): machines differ by a factor of three, ratios to that do not.
"""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np
import scipy
from threadpoolctl import threadpool_limits

from backends.virtual.datasets import make_runs
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.dynamics import robot_from_profile
from pa10d.identify import identify
from pa10d.judgement import in_band
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel
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
        matrix = fit_side(in_band(model), fit, held)
        times, processor, bare = [], [], []
        for number in range(rounds + 1):
            bare.append(factorisation(matrix))
            wall, cpu = time.perf_counter(), time.process_time()
            found = diagnose(model, fit, held)
            if number:
                times.append(time.perf_counter() - wall)
                processor.append(time.process_time() - cpu)
        once = statistics.median(bare)
        out[name] = {
            "seconds": statistics.median(times),
            "processor_seconds": statistics.median(processor),
            "factorisation_seconds": once,
            "matrix": list(matrix.shape),
            "factorisations": round(statistics.median(times) / once, 1),
            "verdict": found.verdict,
            "found": [f.term.label for f in found.findings],
        }
    return out


def fit_side(model: TorqueModel, fit: list[Recording], held: list[Recording]) -> np.ndarray:
    """(M, p+1) weighted columns of the given model on the fit side, and the torque."""
    train, judged, _ = two_sides(model, fit, held)
    state = SearchState.start(model, train, judged)
    blocks = [
        np.column_stack([columns, train.tau[j]]) / state.fit.sigma[j]
        for j, columns in state.matrix(0).items()
    ]
    return np.concatenate(blocks)


@threadpool_limits.wrap(limits=1, user_api="blas")
def factorisation(matrix: np.ndarray) -> float:
    """Seconds for its triangular factor, one thread."""
    started = time.perf_counter()
    scipy.linalg.qr(matrix, mode="r", check_finite=False)
    return time.perf_counter() - started


def sentences(figures: dict[str, Any]) -> str:
    """For a person."""
    return "\n".join(
        f"{name}: {f['seconds']:.1f} s ({f['processor_seconds']:.1f} s of processor time), "
        f"verdict {f['verdict']} {', '.join(f['found'])}; {f['factorisations']:g} times as long as "
        f"one factorisation of its {f['matrix'][0]} x {f['matrix'][1]} matrix "
        f"({f['factorisation_seconds']:.3f} s)"
        for name, f in figures.items()
    )
