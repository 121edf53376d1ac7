"""A line in the spectrum of what is left against time, in both sides at one frequency.

A fan, mains, a neighbour's machine: neither motion nor the library's effects know of it, and it is
no slow noise. It is sought on the fit side and asked for on the held-out side, there against the
level around it, as noise of any colour has one. Motion of sums of sines is made of lines, and so is
what it leaves: one that an angle, a speed or a direction has too is the motion's.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    FORETOLD_LEVEL,
    HUM_ALIKE,
    HUM_AROUND,
    HUM_FINENESS,
    HUM_LEAST_TURNS,
    HUM_SAMPLES,
    HUM_SHARE,
)
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.regression.per_joint import Mask, PerJoint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Hum:
    """hertz of the line; share of the joint's held-out squared error that it is; rms N·m of it."""

    joint: int
    hertz: float
    share: float
    rms: float
    p_value: float


def hums(state: SearchState, joints: Sequence[int]) -> list[Hum]:
    """Of those of the joints that have such a line."""
    train, held = state.train_residual(), state.held_residual()
    found = (_of_joint(state, train, held, j) for j in joints)
    return [one for one in found if one is not None]


def _of_joint(state: SearchState, train: PerJoint, held: PerJoint, j: int) -> Hum | None:
    parts = _stretches(state.train, train, j), _stretches(state.held, held, j)
    longest = [max((t[-1] - t[0] for t, _ in part), default=0.0) for part in parts]
    if min(longest) <= 0.0:
        return None
    cutoff = state.train.runs[0].lowpass.cutoff
    fine = 1.0 / (HUM_FINENESS * max(longest))
    lowest = HUM_LEAST_TURNS / min(longest)
    if lowest >= cutoff:
        return None
    hertz = np.arange(lowest, cutoff, fine)
    fitted = _power(parts[0], hertz)
    line = int(np.argmax(fitted))
    # the line is known to the resolution of the fit side
    reach = int(np.ceil(1.0 / (longest[0] * fine)))
    around = np.arange(
        max(line - HUM_AROUND * reach, 0), min(line + HUM_AROUND * reach, len(hertz))
    )
    power = _power(parts[1], hertz[around])
    own, beside = np.abs(around - line) <= reach, np.abs(around - line) > 2 * reach
    if not beside.any():  # runs so short that the band has no room for neighbours
        return None
    most = float(power[own].max())
    tried = state.train.n * 2.0 * reach / HUM_FINENESS
    p = min(1.0, tried * _chance(power, own, beside))
    whole = float(sum(np.sum(x**2) for _, x in parts[1]))
    share = min(most / max(whole, 1e-300), 1.0)
    size = [
        np.sqrt(m / sum(len(t) for t, _ in q))
        for m, q in zip((fitted[line], most), parts, strict=True)
    ]
    if p > FORETOLD_LEVEL or share < HUM_SHARE or size[0] < HUM_ALIKE * size[1]:
        return None
    for motion in _motions(state.held, j):
        moved = _power(motion, hertz[around])
        skirts = moved[beside & (np.abs(around - line) <= 4 * reach)].max(initial=0.0)
        if moved[own].max() > skirts and tried * _chance(moved, own, beside) <= FORETOLD_LEVEL:
            return None
    rms = float(np.sqrt(share * np.mean(held[j] ** 2)))
    return Hum(j, float(hertz[around][own][int(np.argmax(power[own]))]), share, rms, p)


def _chance(power: Array, own: Mask, beside: Mask) -> float:
    """That noise of the level ``beside`` the line has as much at one of its frequencies."""
    level = float(np.median(power[beside])) / np.log(2.0)
    return float(np.exp(-float(power[own].max()) / max(level, 1e-300)))


def _motions(side: Side, j: int) -> Iterator[list[tuple[Array, Array]]]:
    """Angle, speed and direction of every joint, seen as joint j's torque is."""
    for k in range(side.n):
        seen = [
            run.filtered(np.column_stack([c.q[:, k], c.dq[:, k], np.sign(c.dq[:, k])]), j)
            for run, c in zip(side.runs, side.contexts, strict=True)
        ]
        for one in range(seen[0].shape[1]):
            rows = side.gathered([x[:, one] for x in seen], j)
            yield _stretches(side, {j: rows - rows.mean()}, j)


def _stretches(side: Side, residual: PerJoint, j: int) -> list[tuple[Array, Array]]:
    """Per run: the times (k,) s of the samples that count, and what is left there, N·m."""
    out = []
    for run, (rows, keep) in zip(side.runs, side.stretches(j, residual[j]), strict=True):
        if keep.any():
            out.append((run.t[keep][:HUM_SAMPLES], rows[keep][:HUM_SAMPLES]))
    return out


def _power(stretches: Sequence[tuple[Array, Array]], hertz: Array) -> Array:
    """(k,) (N·m)² times samples: squared error that a sine of each frequency takes, of every run
    one with a phase of its own (Lomb 1976)."""
    total = np.zeros(len(hertz))
    for t, x in stretches:
        total += 2.0 * scipy.signal.lombscargle(t, x, 2.0 * np.pi * hertz)
    return total
