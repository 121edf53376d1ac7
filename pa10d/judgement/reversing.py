"""Does an error turn round with the joint? Noise does not know which way a joint moves.

Friction that wanders (a seal, a lubricant, a temperature that nobody measured) follows no quantity
of the motion but one: just after a reversal it acts the other way. So the error a little before a
reversal is set against that a little after it, each taken against the motion, and without what is
constant or grows with speed (a friction that is a little off is no wandering one). Of noise that
goes on alike, of any colour, the product is as often negative as positive, or more often: slow
noise is the same on both sides, so against the motion it changes its sign. Wilcoxon's signed ranks
of the reversals.

Noise that swings could have turned round by itself in that time. Then it would also do so within a
stroke: as long after, what is looked for must have kept its sign there.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.judgement.residuals import RunResidual

Array = NDArray[np.float64]

FEWEST = 12  # reversals below which nothing is said: 2⁻¹² is as unlikely as such a word may be
PARTS = 3  # windows that a stroke must be long: its end, and room towards the reversals


@dataclass(frozen=True)
class Reversing:
    """Of one joint. p_value: one-sided, that noise keeps its side of the motion that much; share:
    of the squared error, that does (no less: it wanders on meanwhile); reversals: looked at."""

    p_value: float
    share: float
    reversals: int


@dataclass(frozen=True)
class _Stroke:
    """direction: of the motion; error: N·m of the samples that are judged; at: their indices;
    speed: rad/s or m/s, of each."""

    direction: float
    error: Array
    at: NDArray[np.int64]
    speed: Array


def reversing(runs: Sequence[RunResidual]) -> list[Reversing | None]:
    """Per joint; None where it has turned round too seldom."""
    return [_of_joint(runs, j) for j in range(runs[0].error.shape[1])]


def _of_joint(runs: Sequence[RunResidual], joint: int) -> Reversing | None:
    width = max(_width(run) for run in runs)
    pairs: list[tuple[float, float, float, float]] = []  # against the motion, and speeds
    lags: list[int] = []
    strokes = [_strokes(run, joint, width) for run in runs]
    for of_run in strokes:
        for before, after in itertools.pairwise(of_run):
            if before.direction * after.direction < 0:
                end, begin = slice(-2 * width, -width), slice(width, 2 * width)
                pairs.append((*_mean(before, end), *_mean(after, begin)))
                lags.append(int(after.at[begin][0] - before.at[end][0]))
    if len(pairs) < FEWEST or not _keeps_its_sign(strokes, width, int(np.median(lags))):
        return None
    against, speed = np.array(pairs)[:, [0, 2]], np.array(pairs)[:, [1, 3]]
    known = np.column_stack([np.ones(speed.size), speed.ravel()])
    left = against.ravel() - known @ np.linalg.lstsq(known, against.ravel(), rcond=None)[0]
    products = np.prod(left.reshape(-1, 2), axis=1)
    counted = np.concatenate([run.error[run.judged[:, joint], joint] for run in runs])
    share = float(products.mean()) / max(float(np.mean(counted**2)), 1e-300)
    p = float(scipy.stats.wilcoxon(products, alternative="greater").pvalue)
    return Reversing(p, float(np.clip(share, 0.0, 1.0)), len(pairs))


def _width(run: RunResidual) -> int:
    """Samples of one period of the cut-off: a mean over them is worth two independent ones."""
    return int(np.ceil(run.equation.rate / run.equation.lowpass.cutoff))


def _strokes(run: RunResidual, joint: int, width: int) -> list[_Stroke]:
    """Long enough ones, in the order of time; what lies between two is a reversal or a rest."""
    velocity = run.decimated(run.seen.dq)[: len(run.error), joint]
    judged = run.judged[:, joint]
    error = run.error[:, joint]
    side = np.sign(velocity) * judged
    edges = np.flatnonzero(np.diff(np.concatenate([[0.0], side, [0.0]])))
    out = []
    for start, stop in itertools.pairwise(edges):
        if side[start] != 0.0 and stop - start >= PARTS * width:
            part = slice(start, stop)
            speed = np.abs(velocity[part])
            out.append(_Stroke(float(side[start]), error[part], np.arange(start, stop), speed))
    return out


def _mean(stroke: _Stroke, part: slice) -> tuple[float, float]:
    """Mean error against the motion, mean speed."""
    return stroke.direction * float(stroke.error[part].mean()), float(stroke.speed[part].mean())


def _keeps_its_sign(strokes: Sequence[Sequence[_Stroke]], width: int, lag: int) -> bool:
    """Within strokes, is the error ``lag`` samples later rather the same than the opposite?"""
    products = []
    for stroke in (s for of_run in strokes for s in of_run):
        for start in range(0, len(stroke.error) - lag - width + 1, width):
            now, later = slice(start, start + width), slice(start + lag, start + lag + width)
            products.append(float(stroke.error[now].mean()) * float(stroke.error[later].mean()))
    return bool(products) and float(np.mean(products)) > 0.0
