"""Identification of a seven-joint arm: from arrays in memory to base parameters with errors.

Timed is the whole of ``identify``: differentiation, filtering of both sides, the search for the
friction sign's sharpness and for a timing shift, weighted least squares, errors that respect
autocorrelation, feasible standard parameters and warnings. Interpreter start and compilation are
shown apart. Beside it, in the same run on one thread, what a textbook does with Pinocchio and NumPy
(``plain_peer``), and FIGAROH where it is installed (``figaroh_peer``), position, velocity and
acceleration given to them. Ratios are of processor time, which other work disturbs less.
"""

from __future__ import annotations

import subprocess
import sys
import time
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import plain_peer
from threadpoolctl import threadpool_limits

from pa10d.dynamics import Robot, inverse_dynamics, robot_from_profile
from pa10d.effects.base import smooth_sign
from pa10d.identify import identify
from pa10d.measurement.recording import Recording
from pa10d.profile import load_profile
from pa10d.regression.equation import prepare

RATE = 500.0  # Hz
CUTOFF = 10.0  # Hz
SAID = {"plain": "Pinocchio and NumPy", "figaroh": "FIGAROH"}
SCALE = np.array([1.0, 1.0, 0.5, 0.5, 0.1, 0.1, 0.1])


class Spent(NamedTuple):
    """Wall-clock and processor time, s."""

    wall: float
    processor: float


@dataclass(frozen=True)
class Data:
    """Motion and noisy torque in memory, and the torque without noise."""

    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    tau: np.ndarray
    true: np.ndarray

    def recording(self) -> Recording:
        return Recording("bench", np.arange(len(self.q)) / RATE, self.q, self.tau)


def arm() -> Robot:
    return robot_from_profile(load_profile("pa10-7c"))


def data(robot: Robot, samples: int, seed: int) -> Data:
    """A Fourier series per joint, rigid bodies, rotor inertia, friction, white noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) / RATE
    q, dq, ddq = (np.zeros((samples, robot.n)) for _ in range(3))
    for k in range(1, 6):
        w = 2 * np.pi * k / 10.0
        a, phase = rng.uniform(0.2, 0.6, robot.n) / k, rng.uniform(0, 6.28, robot.n)
        q += a * np.sin(w * t[:, None] + phase)
        dq += a * w * np.cos(w * t[:, None] + phase)
        ddq -= a * w * w * np.sin(w * t[:, None] + phase)
    sign = np.column_stack([smooth_sign(v, 0.005) for v in dq.T])
    true = inverse_dynamics(robot, robot.parameters, q, dq, ddq)
    true = true + SCALE * (0.5 * ddq + 8.0 * sign + 12.0 * dq)
    return Data(q, dq, ddq, true + 0.3 * SCALE * rng.normal(size=q.shape), true)


def run(repeats: int = 3, figaroh: str = "auto") -> dict[str, Any]:
    """figaroh: auto (where installed), yes or no."""
    robot = arm()
    unseen = data(robot, 3000, seed=99)
    started = time.perf_counter()
    identify([data(robot, 2000, 0).recording()], robot, name="warm", cutoff=CUTOFF)
    first = time.perf_counter() - started
    figures: dict[str, Any] = {
        "joints": robot.n,
        "rate_hz": RATE,
        "start_and_import_s": round(_start_time(), 2),
        "first_call_s": round(first, 2),
        "runs": [],
    }
    peers = {"plain": plain_peer}
    with_figaroh = figaroh == "yes" or (figaroh == "auto" and _figaroh_installed())
    if with_figaroh:
        import figaroh_peer

        peers["figaroh"] = figaroh_peer
    for samples in (10_000, 100_000):
        measured = data(robot, samples, seed=1)
        spent, model = _timed(
            lambda d=measured: identify([d.recording()], robot, name="b", cutoff=CUTOFF), repeats
        )
        entry: dict[str, Any] = {
            "samples": samples,
            "seconds": round(spent.wall, 3),
            "processor_seconds": round(spent.processor, 3),
            "parameters": len(model.covariance),
            "torque_error": _error(model, unseen),
        }
        for name, peer in peers.items():
            theirs, found = _timed(lambda d=measured, p=peer: p.identify(robot, d), 1)
            entry[f"{name}_seconds"] = round(theirs.wall, 2)
            entry[f"{name}_processor_seconds"] = round(theirs.processor, 2)
            entry[f"times_{name}"] = round(theirs.processor / spent.processor, 1)
            if name == "figaroh":
                entry["figaroh_torque_error"] = found.error(unseen)
        figures["runs"].append(entry)
    return figures


def sentences(figures: dict[str, Any]) -> str:
    lines = [
        f"{figures['joints']} joints at {figures['rate_hz']:g} Hz; apart: interpreter and imports "
        f"{figures['start_and_import_s']} s, first call (compilation) {figures['first_call_s']} s"
    ]
    for entry in figures["runs"]:
        line = (
            f"{entry['samples']:7d} samples: {entry['seconds']:.3f} s to {entry['parameters']} "
            f"parameters with standard errors; torque error on an unseen motion "
            f"{max(entry['torque_error']):.3g} N·m at most"
        )
        for name in ("plain", "figaroh"):
            if f"times_{name}" in entry:
                line += (
                    f"; {SAID[name]} {entry[f'{name}_seconds']:.2f} s "
                    f"({entry[f'times_{name}']} times the processor time)"
                )
        if "figaroh_torque_error" in entry:
            line += f", error {max(entry['figaroh_torque_error']):.3g} N·m"
        lines.append(line)
    return "\n".join(lines)


@threadpool_limits.wrap(limits=1, user_api="blas")
def _timed(work: Any, repeats: int) -> tuple[Spent, Any]:
    """Medians on one thread, and the result."""
    spent, result = [], None
    for _ in range(repeats):
        wall, processor = time.perf_counter(), time.process_time()
        result = work()
        spent.append((time.perf_counter() - wall, time.process_time() - processor))
    return Spent(*(float(v) for v in np.median(spent, axis=0))), result


def _error(model: Any, unseen: Data) -> list[float]:
    """RMS against the true torque per joint, N·m."""
    run = prepare(unseen.recording(), model.robot, model.cutoff)
    inner = slice(300, -300)
    error = (model.predict(run.context) - unseen.true)[inner]
    return [round(float(v), 5) for v in np.sqrt(np.mean(error**2, axis=0))]


def _start_time() -> float:
    started = time.perf_counter()
    subprocess.run([sys.executable, "-c", "import pa10d.identify"], check=True)
    return time.perf_counter() - started


def _figaroh_installed() -> bool:
    import importlib.util

    return importlib.util.find_spec("figaroh") is not None
