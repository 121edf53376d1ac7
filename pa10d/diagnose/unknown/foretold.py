"""Does the motion foretell what is left, where no map of one or two quantities does?

Three joints together, products across joints, what a joint did before, what happens late in a run:
a ridge regression on many features of many quantities at once knows none of them by name, but
where it foretells the held-out residual from what the fit side left, that residual is no noise.
Which quantities it looks at, and how stiff it is, is settled on the fit side alone. Where the
held-out side moves elsewhere, stretches of the fit side that take turns say it of each other.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement, islice, permutations
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.parallel import shared_map
from pa10d.diagnose.constants import (
    BLOCK_SECONDS,
    FORETOLD_DEGREE,
    FORETOLD_FOLDS,
    FORETOLD_LATE,
    FORETOLD_LEVEL,
    FORETOLD_MISSED,
    FORETOLD_RIDGES,
    FORETOLD_SHARP,
    FORETOLD_THIN,
    FORETOLD_TRIED,
    FORETOLD_TURNS,
    FORETOLD_WAVES,
    FORETOLD_WIDTHS,
    FORETOLD_WORK,
    LEAST_FREE,
    MAP_MEMORIES,
    WORTH_JUDGING,
)
from pa10d.diagnose.evidence.held_out import judge
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.diagnose.unknown.structure import (
    KNOWN_GROUND,
    Prediction,
    evidence_of,
    holds,
    motion_variables,
    noise_beside,
    of_all,
    rows_of,
)
from pa10d.diagnose.unknown.taken_together import together

Array = NDArray[np.float64]
Motion = list[dict[str, Array]]


@dataclass(frozen=True)
class Foretold:
    """joint (0-based) and the quantities together that foretell its residual, of those tried
    together as few as do it about as well; share: of all its squared error; there: where the fit
    side has been; elsewhere: the held-out side has not been there, and all this is about the fit
    side."""

    joint: int
    names: tuple[str, ...]
    share: float
    rms: float
    p_value: float
    there: float
    elsewhere: bool = False

    def unnamed(self) -> Unnamed:
        """As an entry of what is unexplained."""
        witness: Literal["elsewhere", "motion"] = "elsewhere" if self.elsewhere else "motion"
        words = together(self.names)
        return Unnamed(self.joint, self.share, self.rms, self.p_value, witness, best_from=words)


def foretold(
    state: SearchState, joints: Sequence[int], of_fit_side: Sequence[int] = ()
) -> list[Foretold]:
    """Of these joints, the ones whose held-out residual motion foretells; of others, those whose
    residual on the fit side it does."""
    if not joints and not of_fit_side:
        return []
    motions = _quantities(state.train), _quantities(state.held)
    asked = list(joints)
    found = shared_map(lambda j: _of_joint(state, motions, j), asked)
    predictions = [p for of_joint in found for p in of_joint]
    unseen = [j for j, of_joint in zip(asked, found, strict=True) if not of_joint]
    unseen += of_fit_side
    elsewhere = shared_map(lambda j: _of_fit_side(state, motions[0], j), unseen)
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
    said = [*best.values(), *(one for one in elsewhere if one is not None)]
    return [replace(one, names=_needed(state, motions[0], one)) for one in said]


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
        (*own, *(f"turned{joint + 1} {s:g} s" for s in FORETOLD_TURNS)),
    ]
    for k in range(n):
        if k != joint:
            out.append((*own[::2], rubs(joint, k), f"q{k + 1}"))
            there = (f"q{k + 1}", f"dq{k + 1}", f"turn{k + 1}")
            out.append((*own, *there, f"ddq{k + 1}"))
            out.append((*own, *there, *(f"q{k + 1} {s:g} s ago" for s in MAP_MEMORIES)))
            out.append((*own, *_work(k)))
    return list(dict.fromkeys(tuple(dict.fromkeys(names)) for names in out))


def rubs(joint: int, other: int) -> str:
    """Which way a joint (0-based) turns, by how fast the other one does."""
    return f"turn{joint + 1}·|dq{other + 1}|"


def _work(joint: int) -> tuple[str, ...]:
    return tuple(f"work{joint + 1} {s:g} s" for s in FORETOLD_WORK)


def _quantities(side: Side) -> Motion:
    """Motion variables, and besides: which way a joint turns, also by another one's speed, its
    speed a while before, how much it moved of late and which way, time."""
    out = motion_variables(side.runs)
    for run, names in zip(side.runs, out, strict=True):
        names["time"] = run.t
        for j in range(side.n):
            speed = names[f"dq{j + 1}"]
            fast = max(float(np.quantile(np.abs(speed), 0.99)), 1e-12)
            names[f"turn{j + 1}"] = np.tanh(speed / (FORETOLD_SHARP * fast))
            for s in FORETOLD_WORK:
                names[f"work{j + 1} {s:g} s"] = _lately(np.abs(speed), s * run.rate)
            for s in FORETOLD_TURNS:
                turned = _lately(names[f"turn{j + 1}"], s * run.rate)
                names[f"turned{j + 1} {s:g} s"] = turned
            for s in FORETOLD_LATE:
                late = min(round(s * run.rate), len(speed) - 1)
                names[f"dq{j + 1} {s:g} s before"] = np.concatenate(
                    [np.full(late, speed[0]), speed[: len(speed) - late]]
                )
        for j, k in permutations(range(side.n), 2):
            names[rubs(j, k)] = names[f"turn{j + 1}"] * np.abs(names[f"dq{k + 1}"])
    return out


def _lately(values: Array, samples: float) -> Array:
    """(M,) their mean of late, over so many samples."""
    pole = np.exp(-1.0 / samples)
    return np.asarray(scipy.signal.lfilter([1.0 - pole], [1.0, -pole], values))


def _of_joint(state: SearchState, motions: tuple[Motion, Motion], joint: int) -> list[Prediction]:
    """The strongest of the sets whose quantities the held-out side shares with the fit side."""
    tried = [_fitted(state, motions[0], joint, names) for names in sets_of(joint, state.train.n)]
    good = (t.predict(state, motions[1]) for t in _strongest(tried))
    known = (p for p in good if p.inside.mean() >= KNOWN_GROUND)
    return list(islice(known, FORETOLD_TRIED))


def _of_fit_side(state: SearchState, motion: Motion, joint: int) -> Foretold | None:
    """What stretches of the fit side foretell of each other. Set and ridge are settled anew for
    each of them, on the others, so that what is foretold owes nothing to the choice."""
    sets = sets_of(joint, state.train.n)
    tried = [_fitted(state, motion, joint, names, anew=True) for names in sets]
    gains = np.array([t.gains_of_others for t in tried])  # sets x stretches x ridges
    values = np.zeros(len(state.fit.residual[joint]))
    for f in range(FORETOLD_FOLDS):
        best, ridge = np.unravel_index(int(np.argmax(gains[:, f])), gains[:, f].shape)
        if gains[best, f, ridge] > 0.0:
            values += tried[best].stretch(state, motion, f, int(ridge))
    if not np.any(values):
        return None
    residual = {j: r * state.fit.sigma[j] for j, r in state.fit.residual.items()}
    found = judge(state.train, residual, {joint: values}, of_itself=True)
    share = 1.0 - float((found.after[joint] / found.before[joint]) ** 2)
    p = min(1.0, _by_chance(values, residual[joint], found.z) * state.train.n)
    if not (p < FORETOLD_LEVEL and holds(found, share)):
        return None
    rms = float(np.sqrt(np.mean(values**2)))
    names = max(tried, key=lambda t: t.gain).names
    return Foretold(joint, names, share, rms, p, share, elsewhere=True)


def _by_chance(said: Array, found: Array, z: float) -> float:
    """p (one-sided) of two signals (m,) that agree so well and have nothing to do with each other.
    z: of their product, under the spectrum of what was found, which says how many samples (z/r)² of
    it are as good as independent. Slow as they are, few agree nearly wholly by accident (t)."""
    r = float(said @ found / np.sqrt((said @ said) * (found @ found)))
    free = (z / r) ** 2 - 2.0 if r > 0.0 else 0.0
    if free < LEAST_FREE:
        return 1.0
    return float(scipy.stats.t.sf(r * np.sqrt(free / max(1.0 - r**2, 1e-12)), free))


def _needed(state: SearchState, motion: Motion, found: Foretold) -> tuple[str, ...]:
    """Without the quantities that are missed least, one after the other, while stretches of the fit
    side foretell about as much of each other."""

    def gain(names: tuple[str, ...]) -> float:
        return _fitted(state, motion, found.joint, names).gain

    names = found.names
    enough = FORETOLD_MISSED * gain(names)
    while len(names) > 1:
        fewer = [tuple(n for n in names if n != one) for one in names]
        gains = [gain(some) for some in fewer]
        best = int(np.argmax(gains))
        if gains[best] < enough:
            break
        names = fewer[best]
    return names


def _strongest(tried: Sequence[_Fitted]) -> list[_Fitted]:
    """Those that foretell stretches of the fit side about as well as the best of them."""
    most = max(t.gain for t in tried)
    good = (t for t in tried if t.gain > 0 and t.gain >= WORTH_JUDGING * most)
    return sorted(good, key=lambda t: -t.gain)


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
    ridges: Array
    gains_of_others: Array
    """stretches x ridges: what the others foretell of each other without that stretch; zero where
    nobody asked"""

    def stretch(self, state: SearchState, motion: Motion, f: int, ridge: int) -> Array:
        """(m_j,) N·m: one stretch of the fit side as the others, but for what touches it in time,
        foretell it; zero elsewhere."""
        fit, side, joint = state.fit, state.train, self.joint
        raw = self.features(_stacked(side, motion, self.names, joint))
        columns = raw / self.scale / fit.sigma[joint]
        own = columns - fit.basis[joint] @ (fit.basis[joint].T @ columns)
        asked = np.arange(len(own)) * FORETOLD_FOLDS // len(own) == f
        moments = side.gathered([_moments(run.t, k) for k, run in enumerate(side.runs)], joint)
        others = _apart(moments, moments[asked])
        known = own[others][::FORETOLD_THIN]
        wanted = known.T @ fit.residual[joint][others][::FORETOLD_THIN]
        gram = known.T @ known + self.ridges[ridge] * np.eye(own.shape[1])
        values = np.zeros(len(own))
        values[asked] = own[asked] @ np.linalg.solve(gram, wanted)
        return values * float(fit.sigma[joint])

    def predict(self, state: SearchState, motion: Motion) -> Prediction:
        x = _stacked(state.held, motion, self.names, self.joint)
        inside = self.features.inside(x)
        said = (self.features(x) / self.scale) @ self.theta
        values = said - state.held_matrix[self.joint] @ self.absorbed
        return Prediction(self.joint, self.names, np.where(inside, values, 0.0), inside)


def _stacked(side: Side, motion: Motion, names: Sequence[str], joint: int) -> Array:
    return np.column_stack([rows_of(side, motion, name, joint) for name in names])


def _moments(t: Array, run: int) -> Array:
    """(M, 2): which run, and when in it (s)."""
    return np.column_stack([np.full(len(t), float(run)), t])


def _apart(moments: Array, asked: Array) -> NDArray[np.bool_]:
    """(rows,): which of these moments lie in no stretch that is asked about, nor just beside it."""
    apart = np.ones(len(moments), dtype=bool)
    for run in np.unique(asked[:, 0]):
        there = asked[asked[:, 0] == run, 1]
        beside = np.abs(moments[:, 1] - np.clip(moments[:, 1], there[0], there[-1])) < BLOCK_SECONDS
        apart &= (moments[:, 0] != run) | ~beside
    return apart


def _fitted(
    state: SearchState, motion: Motion, joint: int, names: tuple[str, ...], anew: bool = False
) -> _Fitted:
    """anew: it will be asked of each stretch anew, as if that had not been seen."""
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
    pairs = _held_back(own, residual, ridges, anew)
    each = np.einsum("ffr->fr", pairs)
    gains = each.sum(axis=0)
    best = int(np.argmax(gains))
    theta = np.linalg.solve(own.T @ own + ridges[best] * np.eye(own.shape[1]), own.T @ residual)
    return _Fitted(
        joint, names, features, scale, theta, fit.to_beta @ (seen @ theta), float(gains[best]),
        ridges, pairs.sum(axis=1) - each,
    )  # fmt: skip


def _held_back(columns: Array, residual: Array, ridges: Array, pairs: bool) -> Array:
    """(folds, folds, ridges): squared error of the second stretch that each ridge removes which was
    fitted to neither of both; without pairs only of each stretch that none was fitted to."""
    fold = np.arange(len(columns)) * FORETOLD_FOLDS // len(columns)
    grams = np.array([columns[fold == f].T @ columns[fold == f] for f in range(FORETOLD_FOLDS)])
    sides = np.array([columns[fold == f].T @ residual[fold == f] for f in range(FORETOLD_FOLDS)])
    gains = np.zeros((FORETOLD_FOLDS, FORETOLD_FOLDS, len(ridges)))
    stretches = range(FORETOLD_FOLDS)
    both: Iterable[tuple[int, int]] = zip(stretches, stretches, strict=True)
    if pairs:
        both = combinations_with_replacement(stretches, 2)
    for f, g in both:
        left_out = [*{f, g}]
        values, vectors = np.linalg.eigh(grams.sum(axis=0) - grams[left_out].sum(axis=0))
        turned = vectors.T @ (sides.sum(axis=0) - sides[left_out].sum(axis=0))
        for k, ridge in enumerate(ridges):
            theta = vectors @ (turned / (np.maximum(values, 0.0) + ridge))
            for a, b in {(f, g), (g, f)}:
                gains[a, b, k] = 2.0 * float(theta @ sides[b]) - float(theta @ grams[b] @ theta)
    return gains
