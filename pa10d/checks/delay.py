"""How late the torque channel is against the position, and whether friction brakes.

The textbook model is fitted to the whole recording; what its residual has in common with the
slope of the model's torque, beyond what the model could absorb, is the delay.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import Finding, joint_label
from pa10d.dynamics import Robot, base_parameters
from pa10d.measurement.recording import Recording
from pa10d.regression.equation import RunEquation, delayed, prepare

Array = NDArray[np.float64]

CUTOFF = 10.0  # Hz
LONGEST = 120.0  # s of the recording that are used: more does not sharpen the answer
BLOCK = 1.0  # s whose residuals are taken as one: longer than any filter remembers
FEWEST = 12  # blocks for an honest standard error
FARTHEST = 0.05  # s: beyond that the linearisation means nothing
SLOW = 0.03  # of the fast speed: there friction may be anything


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
    columns = _columns(run)
    blocks = _blocks(run)
    keep = run.keep & _steady_sign(run)
    if keep.sum() < 3 * columns.shape[2] or len(np.unique(blocks[keep.any(axis=1)])) < 2:
        return None
    weights, seconds, error, count = np.ones(robot.n), 0.0, np.inf, 0
    parameters = np.zeros(columns.shape[2])
    for turn in range(5):
        tau = run.lowpass(delayed(part.tau, -seconds, rate))
        parameters, basis = _fit(columns, tau, keep, weights)
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


def check_delay(recording: Recording, robot: Robot) -> Iterator[Finding]:
    """What the delay and the sign of friction say."""
    delay = estimate_delay(recording, robot)
    if delay is None or not delay.known:
        yield Finding(
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
    yield Finding(
        "warning" if late else "info",
        "delay",
        f"the torque is {abs(delay.seconds) * 1e3:.2f} ms {word} against the position (95 %: "
        f"{low * 1e3:.2f} … {high * 1e3:.2f} ms; one sample is {period * 1e3:.3g} ms)",
        "log both in one cycle, or expect the fit to find a common shift; elasticity that the "
        "textbook model lacks can look the same"
        if late
        else "",
    )
    for j in np.flatnonzero(delay.friction < 0):
        yield Finding(
            "warning",
            "sign",
            f"{joint_label(int(j), robot.joint_names)}: friction would drive instead of brake "
            f"({delay.friction[j]:.2g} W): tau and q may have opposite signs",
            "check the joint's sign; negate one of the two columns",
            int(j) + 1,
        )


def _columns(run: RunEquation) -> Array:
    """(M, n, p): rigid bodies, and per joint rotor inertia, Coulomb, viscous friction, offset."""
    c = run.context
    rigid = run.rigid_columns(base_parameters(c.robot).kept)
    parts = (c.ddq, np.sign(c.dq), c.dq, np.ones_like(c.dq))
    n = c.robot.n
    joint = np.zeros((run.lowpass.kept, n, len(parts) * n))
    for k, part in enumerate(parts):
        joint[:, range(n), range(k * n, (k + 1) * n)] = run.lowpass(part)
    return np.concatenate([rigid, joint], axis=2)


def _steady_sign(run: RunEquation) -> NDArray[np.bool_]:
    """(M, n) False near a joint's reversals and standstills.

    Where friction turns around depends on stiction and creeping, so a reversal would tell a delay
    that is none; moving masses do not lie.
    """
    c = run.context
    fast = np.quantile(np.abs(c.dq), 0.99, axis=0)
    direction = np.where(np.abs(c.dq) > SLOW * fast, np.sign(c.dq), 0.0)
    return np.asarray(np.abs(run.lowpass(direction)) > 0.99)


def _blocks(run: RunEquation) -> NDArray[np.int64]:
    return (run.t / BLOCK).astype(np.int64)


def _fit(
    columns: Array, tau: Array, keep: NDArray[np.bool_], weights: Array
) -> tuple[Array, Array]:
    """Parameters, and an orthonormal basis of what the model can absorb (kept rows)."""
    matrix = (columns * weights[:, None])[keep]
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    u, s, vt = np.linalg.svd(matrix / scale, full_matrices=False)
    sure = s > 1e-8 * s[0]
    inner = (u[:, sure].T @ (tau * weights)[keep]) / s[sure]
    return (vt[sure].T @ inner) / scale, u[:, sure]


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
