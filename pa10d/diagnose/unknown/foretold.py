"""Does the motion foretell what is left, where no map of one or two quantities does?

Three joints together, products across joints, what a joint did before, what happens late in a run:
a ridge regression on many features of many quantities at once knows none of them by name, but
where it foretells the held-out residual from what the fit side left, that residual is no noise.
Which quantities it looks at, and how stiff it is, is settled on the fit side alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.parallel import shared_map
from pa10d.diagnose.constants import (
    FORETOLD_DEGREE,
    FORETOLD_FOLDS,
    FORETOLD_LATE,
    FORETOLD_LEVEL,
    FORETOLD_RIDGES,
    FORETOLD_SHARP,
    FORETOLD_THIN,
    FORETOLD_TRIED,
    FORETOLD_WAVES,
    FORETOLD_WIDTHS,
    FORETOLD_WORK,
    MAP_MEMORIES,
)
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.remaining import Unnamed
from pa10d.diagnose.unknown.structure import (
    KNOWN_GROUND,
    Prediction,
    evidence_of,
    motion_variables,
    noise_beside,
    of_all,
    rows_of,
)

Array = NDArray[np.float64]
Motion = list[dict[str, Array]]


@dataclass(frozen=True)
class Foretold:
    """joint (0-based) and the quantities together that foretell its residual; share: of all its
    squared error; there: where the fit side has been."""

    joint: int
    names: tuple[str, ...]
    share: float
    rms: float
    p_value: float
    there: float

    def unnamed(self) -> Unnamed:
        """As an entry of what is unexplained."""
        return Unnamed(self.joint, self.share, self.rms, self.p_value, witness="motion")


def foretold(state: SearchState, joints: Sequence[int]) -> list[Foretold]:
    """Of these joints, the ones whose held-out residual motion foretells."""
    if not joints:
        return []
    motions = _quantities(state.train), _quantities(state.held)
    found = shared_map(lambda j: _of_joint(state, motions, j), list(joints))
    predictions = [p for of_joint in found for p in of_joint]
    residual = state.held_residual()
    noise = noise_beside(state, residual, predictions)
    best: dict[int, Foretold] = {}
    for p in predictions:
        judged = evidence_of(
            state, residual, p, state.train.n * FORETOLD_TRIED, noise, FORETOLD_LEVEL
        )
        if judged is None:
            continue
        rms = float(np.sqrt(np.mean(p.values**2)))
        whole = of_all(residual, p)
        one = Foretold(p.joint, p.names, whole, rms, judged.p_value, judged.share)
        if p.joint not in best or one.there > best[p.joint].there:
            best[p.joint] = one
    return list(best.values())


def sets_of(joint: int, n: int) -> list[tuple[str, ...]]:
    """Which quantities are looked at together (joints from 1)."""
    own = (f"q{joint + 1}", f"dq{joint + 1}", f"turn{joint + 1}")
    q, dq = ([f"{kind}{k + 1}" for k in range(n)] for kind in ("q", "dq"))
    before = [f"dq{joint + 1} {s:g} s before" for s in FORETOLD_LATE]
    past = tuple(f"q{joint + 1} {s:g} s ago" for s in MAP_MEMORIES)
    out = [
        (*own, f"ddq{joint + 1}", *past, *before),
        tuple(q),
        (*q, *own[1:]),
        (*dq, own[0], own[2]),
        (*own, "time"),
        (*own, *_work(joint)),
    ]
    for k in range(n):
        if k != joint:
            there = (f"q{k + 1}", f"dq{k + 1}", f"turn{k + 1}")
            out.append((*own, *there, f"ddq{k + 1}"))
            out.append((*own, *there, *(f"q{k + 1} {s:g} s ago" for s in MAP_MEMORIES)))
            out.append((*own, *_work(k)))
    return list(dict.fromkeys(tuple(dict.fromkeys(names)) for names in out))


def _work(joint: int) -> tuple[str, ...]:
    return tuple(f"work{joint + 1} {s:g} s" for s in FORETOLD_WORK)


def _quantities(side: Side) -> Motion:
    """Motion variables, and besides: which way a joint turns, its speed a while before, how much it
    moved of late, time."""
    out = motion_variables(side.runs)
    for run, names in zip(side.runs, out, strict=True):
        names["time"] = run.t
        for j in range(side.n):
            speed = names[f"dq{j + 1}"]
            fast = max(float(np.quantile(np.abs(speed), 0.99)), 1e-12)
            names[f"turn{j + 1}"] = np.tanh(speed / (FORETOLD_SHARP * fast))
            for s in FORETOLD_WORK:
                pole = np.exp(-1.0 / (s * run.rate))
                lately = scipy.signal.lfilter([1.0 - pole], [1.0, -pole], np.abs(speed))
                names[f"work{j + 1} {s:g} s"] = lately
            for s in FORETOLD_LATE:
                late = min(round(s * run.rate), len(speed) - 1)
                names[f"dq{j + 1} {s:g} s before"] = np.concatenate(
                    [np.full(late, speed[0]), speed[: len(speed) - late]]
                )
    return out


def _of_joint(state: SearchState, motions: tuple[Motion, Motion], joint: int) -> list[Prediction]:
    tried = [_fitted(state, motions[0], joint, names) for names in sets_of(joint, state.train.n)]
    good = sorted((t for t in tried if t.gain > 0), key=lambda t: -t.gain)[:FORETOLD_TRIED]
    predictions = [t.predict(state, motions[1]) for t in good]
    return [p for p in predictions if p.inside.mean() >= KNOWN_GROUND]


@dataclass(frozen=True)
class _Features:
    """Products and waves of standardised quantities; the same function on either side."""

    middle: Array
    spread: Array
    low: Array
    high: Array
    turns: Array
    phases: Array

    @classmethod
    def of(cls, x: Array, seed: int) -> _Features:
        rng = np.random.default_rng([seed, x.shape[1]])
        width = rng.choice(FORETOLD_WIDTHS, FORETOLD_WAVES)
        turns = (
            rng.standard_normal((x.shape[1], FORETOLD_WAVES)) / width / np.sqrt(0.5 * x.shape[1])
        )
        spread = np.maximum(x.std(axis=0), 1e-12)
        low, high = x.min(axis=0), x.max(axis=0)
        phases = rng.uniform(0, 2 * np.pi, FORETOLD_WAVES)
        return cls(x.mean(axis=0), spread, low, high, turns, phases)

    def __call__(self, x: Array) -> Array:
        """(rows, quantities) -> (rows, features)."""
        z = (np.clip(x, self.low, self.high) - self.middle) / self.spread
        products = [z]
        for degree in range(2, FORETOLD_DEGREE + 1):
            chosen = combinations_with_replacement(range(z.shape[1]), degree)
            products.append(np.column_stack([np.prod(z[:, c], axis=1) for c in map(list, chosen)]))
        return np.column_stack([*products, np.cos(z @ self.turns + self.phases)])

    def inside(self, x: Array) -> NDArray[np.bool_]:
        """(rows,): where the fit side has been, each quantity for itself."""
        return np.asarray(np.all((x >= self.low) & (x <= self.high), axis=1))


@dataclass(frozen=True)
class _Fitted:
    joint: int
    names: tuple[str, ...]
    features: _Features
    scale: Array
    theta: Array
    absorbed: Array
    gain: float

    def predict(self, state: SearchState, motion: Motion) -> Prediction:
        x = _stacked(state.held, motion, self.names, self.joint)
        inside = self.features.inside(x)
        said = (self.features(x) / self.scale) @ self.theta
        values = said - state.held_matrix[self.joint] @ self.absorbed
        return Prediction(self.joint, self.names, np.where(inside, values, 0.0), inside)


def _stacked(side: Side, motion: Motion, names: Sequence[str], joint: int) -> Array:
    return np.column_stack([rows_of(side, motion, name, joint) for name in names])


def _fitted(state: SearchState, motion: Motion, joint: int, names: tuple[str, ...]) -> _Fitted:
    fit = state.fit
    x = _stacked(state.train, motion, names, joint)[::FORETOLD_THIN]
    features = _Features.of(x, joint)
    raw = features(x)
    scale = np.maximum(np.sqrt(np.mean(raw**2, axis=0)), 1e-12)
    columns = raw / scale / fit.sigma[joint]
    basis = fit.basis[joint][::FORETOLD_THIN]
    seen = FORETOLD_THIN * (basis.T @ columns)
    own = columns - basis @ seen
    residual = fit.residual[joint][::FORETOLD_THIN]
    ridges = FORETOLD_RIDGES * len(own) / fit.sigma[joint] ** 2
    gains = _held_back(own, residual, ridges)
    best = int(np.argmax(gains))
    theta = np.linalg.solve(own.T @ own + ridges[best] * np.eye(own.shape[1]), own.T @ residual)
    return _Fitted(
        joint, names, features, scale, theta, fit.to_beta @ (seen @ theta), float(gains[best])
    )


def _held_back(columns: Array, residual: Array, ridges: Array) -> Array:
    """Squared error that each ridge removes on stretches it has not been fitted to."""
    fold = np.arange(len(columns)) * FORETOLD_FOLDS // len(columns)
    grams = np.array([columns[fold == f].T @ columns[fold == f] for f in range(FORETOLD_FOLDS)])
    sides = np.array([columns[fold == f].T @ residual[fold == f] for f in range(FORETOLD_FOLDS)])
    gains = np.zeros(len(ridges))
    for f in range(FORETOLD_FOLDS):
        values, vectors = np.linalg.eigh(grams.sum(axis=0) - grams[f])
        turned = vectors.T @ (sides.sum(axis=0) - sides[f])
        for k, ridge in enumerate(ridges):
            theta = vectors @ (turned / (np.maximum(values, 0.0) + ridge))
            gains[k] += 2.0 * float(theta @ sides[f]) - float(theta @ grams[f] @ theta)
    return gains
