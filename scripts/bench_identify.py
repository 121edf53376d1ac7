"""Identification of a seven-joint arm: from arrays in memory to base parameters with errors.

Timed is the whole of ``identify``: differentiation, filtering of both sides, the search for the
friction sign's sharpness and for a timing shift, weighted least squares, errors that respect
autocorrelation, feasible standard parameters and warnings. Interpreter start and compilation are
shown apart. Where FIGAROH is installed, its regressor, decimation, double QR and weighted least
velocity and acceleration given to it.
"""

from __future__ import annotations

import subprocess
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from pa10d.dynamics import Robot, inverse_dynamics, robot_from_profile
from pa10d.effects.base import smooth_sign
from pa10d.identify import identify
from pa10d.measurement.recording import Recording
from pa10d.profile import load_profile
from pa10d.regression.equation import prepare

RATE = 500.0  # Hz
CUTOFF = 10.0  # Hz
SCALE = np.array([1.0, 1.0, 0.5, 0.5, 0.1, 0.1, 0.1])


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
    with_figaroh = figaroh == "yes" or (figaroh == "auto" and _figaroh_installed())
    for samples in (10_000, 100_000):
        measured = data(robot, samples, seed=1)
        seconds, model = _timed(
            lambda d=measured: identify([d.recording()], robot, name="b", cutoff=CUTOFF), repeats
        )
        entry: dict[str, Any] = {
            "samples": samples,
            "seconds": round(seconds, 3),
            "parameters": len(model.covariance),
            "torque_error": _error(model, unseen),
        }
        if with_figaroh:
            import figaroh_peer

            seconds, peer = _timed(lambda d=measured: figaroh_peer.identify(robot, d), 1)
            entry["figaroh_seconds"] = round(seconds, 2)
            entry["figaroh_torque_error"] = peer.error(unseen)
            entry["times_faster"] = round(entry["figaroh_seconds"] / entry["seconds"], 1)
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
        if "figaroh_seconds" in entry:
            line += (
                f"; FIGAROH {entry['figaroh_seconds']:.2f} s ({entry['times_faster']}x slower), "
                f"error {max(entry['figaroh_torque_error']):.3g} N·m"
            )
        lines.append(line)
    return "\n".join(lines)


def _timed(work: Any, repeats: int) -> tuple[float, Any]:
    """Median wall-clock seconds, and the result."""
    times, result = [], None
    for _ in range(repeats):
        started = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - started)
    return float(np.median(times)), result


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
