"""How late the torque channel is against the position, and whether friction brakes.

The textbook model is fitted to the whole recording; what its residual has in common with the
slope of the model's torque, beyond what the model could absorb, is the delay.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import CheckFinding, Mend, joint_label
from pa10d.checks.textbook_fit import blocks_of, fit_textbook, steady_sign, textbook_columns
from pa10d.dynamics import Robot, base_parameters
from pa10d.measurement.recording import Recording
from pa10d.regression.equation import RunEquation, delayed, prepare

Array = NDArray[np.float64]

CUTOFF = 10.0  # Hz
LONGEST = 120.0  # s of the recording that are used: more does not sharpen the answer
FEWEST = 12  # blocks for an honest standard error
FARTHEST = 0.05  # s: beyond that the linearisation means nothing


@dataclass(frozen=True)
class Delay:
    """seconds: positive where the torque is late. friction: (n,) mean braking power, W."""

    seconds: float
    std_error: float
    blocks: int
    friction: Array

    @property
    def known(self) -> bool:
        """Whether the estimate settled and its error can be stated."""
        return self.blocks >= FEWEST and abs(self.seconds) < FARTHEST


def estimate_delay(recording: Recording, robot: Robot) -> Delay | None:
    """One delay for the whole robot; None where the recording is too short for a fit."""
    rate = recording.rate
    wanted = int(LONGEST * rate)
    first = max(0, (len(recording.t) - wanted) // 2)
    part = recording.part(first, min(len(recording.t), first + wanted), "")
    part = replace(part, dq=None)  # late against the position, not against a reported velocity
    run = prepare(part, robot, min(CUTOFF, rate / 8))
    columns = textbook_columns(run, base_parameters(robot).kept)
    blocks = blocks_of(run)
    keep = run.keep & steady_sign(run)
    if keep.sum() < 3 * columns.shape[2] or len(np.unique(blocks[keep.any(axis=1)])) < 2:
        return None
    weights, seconds, error, count = np.ones(robot.n), 0.0, np.inf, 0
    parameters = np.zeros(columns.shape[2])
    for turn in range(5):
        tau = run.lowpass(delayed(part.tau, -seconds, rate))
        parameters, basis = fit_textbook(columns, tau, keep, weights)
        model = columns @ parameters
        residual = np.where(keep, tau - model, 0.0)
        spread = np.sqrt((residual**2).sum(axis=0) / np.maximum(keep.sum(axis=0), 1))
        if turn == 0:
            weights = 1.0 / np.maximum(spread, 1e-9 * spread.max() + 1e-12)
            continue
        slope = -_slope(model, run.rate)
        slope_left = _beyond(slope, basis, keep, weights)
        residual_left = (residual * weights)[keep]
        information = float(slope_left @ slope_left)
        if information <= 0:
            return None
        seconds += float(slope_left @ residual_left) / information
        rows = np.broadcast_to(blocks[:, None], keep.shape)[keep]
        scores = np.bincount(rows, slope_left * residual_left)
        count = len(np.unique(rows))
        error = float(np.sqrt((scores**2).sum() * count / max(count - 1, 1)) / information)
        if abs(seconds) >= FARTHEST:
            break
    return Delay(seconds, error, count, _braking(run, columns, parameters, robot.n))


def check_delay(recording: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """What the delay and the sign of friction say."""
    delay = estimate_delay(recording, robot)
    if delay is None or not delay.known:
        yield CheckFinding(
            "info",
            "delay_unknown",
            "the delay between torque and position cannot be told from this recording",
            "a longer run with more reversals would show it",
        )
        return
    low, high = (delay.seconds + k * 1.96 * delay.std_error for k in (-1, 1))
    period = 1.0 / recording.rate
    late = low > period or high < -period
    word = "late" if delay.seconds >= 0 else "early"
    yield CheckFinding(
        "warning" if late else "info",
        "delay",
        f"the torque seems {abs(delay.seconds) * 1e3:.2f} ms {word} against the position (95 %: "
        f"{low * 1e3:.2f} … {high * 1e3:.2f} ms; one sample is {period * 1e3:.3g} ms)",
        "log both in one cycle, or expect the fit to find a common shift; elasticity, play or "
        "friction that the textbook model lacks can look the same, and the interval does not know "
        "of them"
        if late
        else "",
    )
    for j in np.flatnonzero(delay.friction < 0):
        tau, q = (Mend(f"{kind}{j + 1}", "-1", complete=False) for kind in ("tau", "q"))
        yield CheckFinding(
            "warning",
            "sign",
            f"{joint_label(int(j), robot.joint_names)}: friction would drive instead of brake "
            f"({delay.friction[j]:.2g} W): tau and q may have opposite signs",
            f"--map {tau.option} if the torque counts the other way, {q.option} if the angle does",
            int(j) + 1,
            (tau, q),
        )


def _beyond(values: Array, basis: Array, keep: NDArray[np.bool_], weights: Array) -> Array:
    rows = (values * weights)[keep]
    return np.asarray(rows - basis @ (basis.T @ rows))


def _slope(model: Array, rate: float) -> Array:
    """Time derivative of a signal that is almost at its Nyquist rate."""
    step = 0.25 / rate
    return (delayed(model, -step, rate) - delayed(model, step, rate)) / (2 * step)


def _braking(run: RunEquation, columns: Array, parameters: Array, n: int) -> Array:
    """Mean power (n,) W that the fitted Coulomb and viscous terms take from the motion."""
    friction = slice(columns.shape[2] - 3 * n, columns.shape[2] - n)
    torque = columns[:, :, friction] @ parameters[friction]
    speed = run.lowpass(run.context.dq)
    return np.asarray((torque * speed).mean(axis=0))
