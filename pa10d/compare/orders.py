"""Power of the error against order: cycles per revolution of the joint.

Ripple of motor, gear and bearing is fixed in the angle, so that its frequency moves with the
speed while its order does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.compare.angle_periodogram import TURNS, periodogram
from pa10d.compare.order_lines import find_lines, has_line, noise_bar, slow_part
from pa10d.judgement.residuals import RunResidual
from pa10d.judgement.scores import moving

Array = NDArray[np.float64]

LOWEST = 4.0  # cycles/rev, and cycles within the range visited: fewer are a curve, no ripple
HIGHEST = 1000.0
NEIGHBOURHOOD = 60  # resolved orders whose median is the noise's local level
HALVES = 1.0  # s: every other such stretch of time makes one half


@dataclass(frozen=True)
class OrderSpectrum:
    """order (K,) cycles/rev; amplitude (K,) N·m of the best sine at each order, as what it takes
    of the error's power; threshold (K,) N·m which noise passes anywhere with chance ALARM;
    lines: (order, amplitude), largest first, one per peak; of_torque: which of them the measured
    torque has; speed: typical, rad/s; rate: Hz of the slowest run."""

    order: Array
    amplitude: Array
    threshold: Array
    lines: tuple[tuple[float, float], ...]
    of_torque: tuple[bool, ...]
    speed: float
    rate: float

    def above(self, cutoff: float) -> list[tuple[float, float]]:
        """Lines of the torque that a low-pass (Hz) takes away at the typical speed. What only the
        model's torque has there are the steps of an encoder, differentiated twice."""
        told = zip(self.lines, self.of_torque, strict=True)
        return [line for line, seen in told if seen and self.frequency(line[0]) > cutoff]

    def frequency(self, order: float) -> float:
        """Hz at the typical speed."""
        return order * self.speed / (2 * np.pi)


def order_spectrum(runs: Sequence[RunResidual], joint: int, most: int = 5) -> OrderSpectrum | None:
    """Of the unfiltered error in motion; None where the joint turns too little to tell orders."""
    used = moving(runs, joint)
    q = np.concatenate([run.seen.q[run.raw_counts[:, joint], joint] for run in used])
    dq = np.concatenate([run.seen.dq[run.raw_counts[:, joint], joint] for run in used])
    error = np.concatenate([run.raw_error[run.raw_counts[:, joint], joint] for run in used])
    rate = min(run.equation.lowpass.rate for run in used)
    span, speed = float(np.ptp(q)), float(np.median(np.abs(dq)))
    if span <= 0 or speed <= 0:
        return None
    lowest = LOWEST * max(1.0, 2 * np.pi / span)
    highest = min(HIGHEST, 0.4 * rate * 2 * np.pi / speed)
    order = np.arange(np.ceil(lowest * TURNS), np.floor(highest * TURNS)) / TURNS
    reach = max(1, round(2 * np.pi / span * TURNS))  # what the visited angle resolves
    if len(order) < 4 * reach:
        return None
    halves = np.arange(len(q)) // max(1, int(HALVES * rate)) % 2 == 0
    torque = np.concatenate([run.equation.raw_tau[run.raw_counts[:, joint], joint] for run in used])
    lines, left = find_lines(q, dq, error, order, NEIGHBOURHOOD * reach, halves, most)
    whole = error - slow_part(q, dq, error)
    bar = noise_bar(periodogram(q, left, order)[0], NEIGHBOURHOOD * reach)
    return OrderSpectrum(
        order,
        np.sqrt(2 * np.mean(whole**2) * periodogram(q, whole, order)[0]),
        np.sqrt(2 * np.mean(left**2) * bar),
        tuple(lines),
        tuple(has_line(q, dq, torque, error, n) for n, _ in lines),
        speed,
        rate,
    )
