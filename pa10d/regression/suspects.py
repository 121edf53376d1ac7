"""How far structure of the size of what a fit leaves could have moved each parameter.

What a model lacks is only seen as far as the model cannot absorb it: of drag beside viscous
friction a twentieth is left, and the parameters have taken the rest. So a residual is looked at
with suspects: smooth functions of the motion, one family at a time. How much of the residual a
family explains bounds its size, what the fit absorbs of it says what moved the parameters. Each
parameter is as uncertain as the worst suspect makes it.

What leaves no trace at all (an offset that is a first moment, a gain) no residual can bound.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.regression.lacking import Stretch

Array = NDArray[np.float64]
Family = tuple[Array, Array]
"""Functions (M, k) at the samples, and the prior variance (k,) of each one's share."""

WAVES = 6  # half waves over a joint's range, the constant among them
SPEEDS = 5  # half waves over the speeds of one direction
FAST = 0.995  # share of the samples that are slower than what counts as fast
TURNING = 0.02  # of the fast speed, over which a direction is smoothed
TRACE = 1e-3  # a family of which less than this share of its power is left shows nothing


class Suspects:
    """The families of functions of a recording's motion."""

    def __init__(self, stretches: Sequence[Stretch]) -> None:
        counted = [s.keep.any(axis=1) for s in stretches]

        def gathered(name: str) -> Array:
            return np.concatenate(
                [getattr(s, name)[k] for s, k in zip(stretches, counted, strict=True)]
            )

        q = gathered("q")
        self._low, self._high = q.min(axis=0, initial=0.0), q.max(axis=0, initial=0.0)
        self._fast, self._hard = (
            np.maximum(np.quantile(np.abs(gathered(name)), FAST, axis=0), 1e-12)
            for name in ("dq", "ddq")
        )

    def families(self, stretch: Stretch, joint: int) -> Iterator[Family]:
        """For the samples of a stretch that count for a joint; always in the same order."""
        keep = stretch.keep[:, joint]
        q, dq = stretch.q[keep], stretch.dq[keep] / self._fast
        speed, hard = dq[:, [joint]], stretch.ddq[keep][:, [joint]] / self._hard[joint]
        way = np.tanh(speed / TURNING)
        n = q.shape[1]
        waves = [_waves(q[:, i], self._low[i], self._high[i], WAVES) for i in range(n)]
        slow_to_fast = _beside(
            _waves(np.abs(speed[:, 0]), 0.0, 1.0, SPEEDS),
            _alone(np.abs(np.hstack([speed, speed**2]))),
        )
        bends = (waves[joint][0][:, 1:4], waves[joint][1][1:4])
        level = (waves[joint][0][:, :3], waves[joint][1][:3])
        yield _times(_alone(way), slow_to_fast)
        yield slow_to_fast
        yield waves[joint]
        yield _times(_alone(way), waves[joint])
        yield _times(_alone(speed), bends)
        yield _alone(np.hstack([hard * np.abs(hard), hard**2, hard**3, way * np.abs(hard)]))
        for i in range(n):
            if i == joint:
                continue
            others, other = waves[i], dq[:, [i]]
            yield others
            yield _times((others[0][:, 1:4], others[1][1:4]), bends)
            yield _times(_alone(way), (others[0][:, 1:], others[1][1:]))
            yield _times(_alone(np.hstack([other, np.tanh(other / TURNING)])), level)
            yield _times(_alone(np.hstack([other**2, other * speed])), level)


class Tally:
    """What a residual of one joint says of each family, summed over stretches.

    Rows given: the orthonormal basis (m, r) of the weighted fit, the residual (m,) N·m, and the
    ``way out`` (m, s), whose product with a torque is what the estimates answer to (default: the
    basis).
    """

    def __init__(self) -> None:
        self._samples = 0
        self._square = 0.0
        self._own: Array = np.zeros(())
        self._along: Array = np.zeros(())
        self._sums: list[list[Array]] = []

    def add(
        self, families: Iterator[Family], basis: Array, residual: Array, out: Array | None = None
    ) -> None:
        """Take in the samples of a stretch."""
        self._samples += len(residual)
        self._square += float(residual @ residual)
        self._own = self._own + basis.T @ basis
        self._along = self._along + basis.T @ residual
        out = basis if out is None else out
        new = [[g.T @ g, basis.T @ g, g.T @ residual, out.T @ g, w] for g, w in families]
        if self._sums:
            new = [
                [*(a + b for a, b in zip(old[:-1], one[:-1], strict=True)), one[-1]]
                for old, one in zip(self._sums, new, strict=True)
            ]
        self._sums = new

    def doubts(self, lack: float) -> list[Array]:
        """(s, s) for each family: the covariance of ``out``'s product with it, were it what the
        joint's residual owes to the model's own lack, ``lack`` (N·m)²."""
        return [] if not self._samples else [self._doubt(lack, *sums) for sums in self._sums]

    def _doubt(
        self, lack: float, gram: Array, absorbed: Array, seen: Array, out: Array, weights: Array
    ) -> Array:
        size = float(np.diag(gram) @ weights) / self._samples
        prior: Array = np.sqrt(weights / max(size, 1e-300))
        left = gram - 2.0 * absorbed.T @ absorbed + absorbed.T @ self._own @ absorbed
        left = prior[:, None] * left * prior
        power = float(np.trace(left)) / self._samples
        told = prior * (seen - absorbed.T @ self._along)
        ridge = 1e-6 * np.trace(left) / len(left) * np.eye(len(left))
        share = float(told @ np.linalg.lstsq(left + ridge, told, rcond=None)[0])
        share = float(np.clip(share / max(self._square, 1e-300), 0.0, 1.0))
        moved = out * prior * np.sqrt(lack * share / max(power, TRACE))
        return np.asarray(moved @ moved.T)


def worst(covariances: Sequence[Array]) -> Array:
    """(p, p): each parameter as uncertain as the worst of several covariances makes it, related to
    the others as in their sum."""
    total = np.sum(covariances, axis=0)
    most, all_of_it = np.max([np.diag(c) for c in covariances], axis=0), np.diag(total)
    # what nothing moves has a variance of rounding errors, below zero as often as above
    share = np.divide(most, all_of_it, out=np.zeros(len(most)), where=all_of_it > 0)
    shrink = np.sqrt(np.clip(share, 0.0, 1.0))
    return np.asarray(total * np.outer(shrink, shrink))


def _waves(x: Array, low: float, high: float, count: int) -> Family:
    """Half cosines from ``low`` to ``high``, the shorter the less likely."""
    order = np.arange(count, dtype=float)
    u = np.clip((x - low) / max(high - low, 1e-12), 0.0, 1.0)
    return np.asarray(np.cos(np.pi * np.outer(u, order))), np.asarray(1.0 / (1.0 + order**2))


def _alone(columns: Array) -> Family:
    return columns, np.ones(columns.shape[1])


def _beside(first: Family, second: Family) -> Family:
    return np.hstack([first[0], second[0]]), np.append(first[1], second[1])


def _times(first: Family, second: Family) -> Family:
    columns = first[0][:, :, None] * second[0][:, None, :]
    weights = np.outer(first[1], second[1]).ravel()
    return columns.reshape(len(columns), len(weights)), weights
