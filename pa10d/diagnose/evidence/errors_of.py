"""Standard errors of a term's coefficients and shapes under autocorrelated noise."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.diagnose.constants import CHOSEN
from pa10d.diagnose.evidence.held_out import ModelUncertainty
from pa10d.diagnose.evidence.reversals import moved_by_reversals
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.partial import normal_equations
from pa10d.diagnose.regression.shapes import free_shapes
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.slopes import with_slopes
from pa10d.diagnose.regression.state import SearchState
from pa10d.effects.rotor import ROTOR
from pa10d.model import Term
from pa10d.regression.covariance import WeightedStretch, uncertainty
from pa10d.regression.lacking import Stretch
from pa10d.regression.per_joint import PerJoint, rms
from pa10d.regression.scores import Memory, ScoreVectors, covariance_of

Array = NDArray[np.float64]
Noises = dict[int, ScoreVectors]
"""joint -> what its noise makes of the scores of a fit's basis."""


def full_covariance(
    state: SearchState, fit: LeastSquares | None = None, noise: PerJoint | None = None
) -> Array:
    """(p, p) of all coefficients under noise alone, as it is correlated: for the search.

    fit: another one of the same columns, some of them left out; noise: weighted residuals (m_j,)
    that know more than its own.
    """
    fit = state.fit if fit is None else fit
    return _covariance(state, fit, _noises(state.train, fit.basis, noise or fit.residual))


def honest_covariance(state: SearchState) -> Array:
    """(p, p) of all coefficients as a model states them: what it lacks itself included. The search
    asks whether there is more than noise; who reads a model asks how far off it may be."""
    state = state.as_free()
    fit = state.fit
    return covariance_under(state, fit.basis, fit.to_beta, _known(state, fit))


@dataclass(frozen=True)
class ModelUncertainties:
    """How uncertain the present model is on the held-out side, whatever is added to it.

    What is missing from a model colours its residual, and noise is only what would be left without
    it. So each joint's noise is what its best candidate leaves, and for a candidate under
    judgement what that one leaves on the joints on which it acts. On data with nothing hidden the
    best of many candidates takes next to nothing away.
    """

    state: SearchState
    noises: Noises

    @classmethod
    def of(cls, state: SearchState, changes: Iterable[PerJoint]) -> ModelUncertainties:
        """changes: what each candidate changes on the fit side (weighted), on its own joints."""
        left = dict(state.fit.residual)
        for change in changes:
            for j, moved in change.items():
                rest = state.fit.residual[j] - moved
                if rest @ rest < left[j] @ left[j]:
                    left[j] = rest
        return cls(state, _noises(state.train, state.fit.basis, left))

    def beside(self, change: PerJoint) -> ModelUncertainty:
        """With a candidate added that changes the fit side so."""
        fit = self.state.fit
        left = {j: fit.residual[j] - moved for j, moved in change.items()}
        own = _noises(self.state.train, fit.basis, left)
        return doubt_under(self.state, {**self.noises, **own})


def doubt_under(state: SearchState, noises: Noises) -> ModelUncertainty:
    """How uncertain the model is on the held-out side under each joint's noise."""
    return ModelUncertainty(state.held_matrix, _covariance(state, state.fit, noises))


def held_noise(
    state: SearchState, joint: int, noise: Array, heard: NDArray[np.bool_]
) -> ScoreVectors:
    """Of the fit side's basis under a joint's noise as the held-out side has it.

    noise: (m_j,) N·m held out; heard: the samples of it that count. What bends so freely that it
    takes noise along leaves too little of it on the side it was fitted to, but not here.
    """
    there = state.held.stretches(joint, heard.astype(float))
    rows = state.held.stretches(joint, noise / state.fit.sigma[joint])
    parts = [(r, t > 0) for (r, _), (t, _) in zip(rows, there, strict=True)]
    scores = ScoreVectors(Memory.of(parts, state.held.runs[0].rate))
    for columns in state.train.spread(joint, state.fit.basis[joint]):
        scores.add(columns)
    return scores


def doubt_of(
    state: SearchState, fit: LeastSquares | None = None, noise: PerJoint | None = None
) -> ModelUncertainty:
    """How uncertain the model is on the held-out side."""
    return ModelUncertainty(state.held_matrix, full_covariance(state, fit, noise))


def moved_by_doubt(state: SearchState, level: float, covariance: Array | None = None) -> Array:
    """(n,) N·m RMS that the uncertainty of the model's own coefficients leaves on the held-out side
    of each joint, exceeded by chance in a share ``level`` of cases only: a sum of squares of
    normal numbers with the variances of the prediction, taken for a χ² (Satterthwaite 1946).

    covariance: (p, p) of the coefficients, if not that of noise alone
    """
    covariance = full_covariance(state) if covariance is None else covariance
    out = np.zeros(state.held.n)
    for j, x in state.held_matrix.items():
        spread = covariance @ (x.T @ x) / max(len(x), 1)
        mean, square = float(np.trace(spread)), float(np.sum(spread * spread.T))
        if mean > 0.0 and square > 0.0:
            out[j] = np.sqrt(square / mean * scipy.stats.chi2.isf(level, mean**2 / square))
    return out


def carried_farther(state: SearchState, covariance: Array, shapes: Array | float = 0.0) -> Array:
    """(n,) how many times more RMS the uncertainty (p, p) of the coefficients and that of shapes
    (2, n) make in each joint's torque on the held-out side than on the fit side: about one where
    the motion is alike."""
    mean = np.zeros((2, state.held.n)) + np.square(shapes)
    for side, columns in enumerate([state.matrix(0), state.held_matrix]):
        for j, x in columns.items():
            mean[side, j] += max(np.sum((x @ covariance) * x) / max(len(x), 1), 0.0)
    return np.sqrt(mean[1] / np.maximum(mean[0], 1e-300))


def moved_by_shapes(state: SearchState, first: int) -> Array:
    """(2, n) N·m RMS that the shapes of the terms from ``first`` on leave open on the fit side and
    on the held-out side: of each, what one of its standard errors moves, all coefficients fitted
    anew. A power of the speed that is known up to 0.1 rad/s says little of 0.3."""
    sides = [state.train_residual(), state.held_residual()]
    square = np.zeros((2, state.held.n))
    for index in range(first, len(state.terms)):
        term = state.terms[index]
        kinds = free_shapes(term.effect, term.shape)
        errors = term_covariance(state, index, of_noise=True)[1] if kinds else {}
        for kind in kinds:
            now, by = term.shape[kind.name], errors[kind.name]
            to = now + by if now + by <= kind.upper else max(now - by, kind.lower)
            trial = state.copy()
            trial.replace_term(index, replace(term, shape={**term.shape, kind.name: to}))
            trial.refit()
            for side, moved in enumerate([trial.train_residual(), trial.held_residual()]):
                for j, residual in moved.items():
                    if len(residual):
                        square[side, j] += float(np.mean((residual - sides[side][j]) ** 2))
    return np.sqrt(square)


def _covariance(state: SearchState, fit: LeastSquares, noises: Noises) -> Array:
    whole, _ = covariance_of(list(noises.values()), [fit.to_beta] * len(noises))
    known = _known(state, fit)
    return whole if known is None else whole + known


def _known(state: SearchState, fit: LeastSquares) -> Array | None:
    """(p, p) what is not of these data: what was known already is as certain as it said."""
    if state.problem.known is None:
        return None
    top = np.sum([q.T @ q for q in fit.basis.values()], axis=0)
    return np.asarray(fit.to_beta @ (np.eye(len(top)) - top) @ fit.to_beta.T)


def term_covariance(
    state: SearchState, index: int, of_noise: bool = False
) -> tuple[Array, dict[str, float]]:
    """Covariance (k, k) of a term's coefficients with its shape free, and the shape's errors.
    of_noise: without what reversals may have drawn them by, of which the data say no more."""
    term = state.terms[index]
    place = state.place(index)
    free = free_shapes(term.effect, term.shape)
    rest = state.fit.without(place)
    columns = with_slopes(state.train, term) if free else dict(state.blocks[index][0])
    k = len(term.coefficients)
    left: PerJoint = {}
    of_rest = sum(rest.basis[j].T @ (c / rest.sigma[j]) for j, c in columns.items())
    for j in range(state.train.n):
        own = columns.get(j)
        absorbed = rest.basis[j] @ of_rest
        left[j] = -absorbed if own is None else own / rest.sigma[j] - absorbed
    seen = np.sum([c.T @ c for c in left.values()], axis=0)
    gram = seen + np.diag(np.r_[np.zeros(k), certain_before(term)])
    if state.problem.known is not None:
        gram = gram - seen + normal_equations(rest, columns)[0]
        penalty = term.effect.penalty(term.shape)
        if penalty is not None:
            gram = gram + penalty.T @ penalty
    inverse = np.asarray(np.linalg.pinv(gram, rcond=1e-12, hermitian=True), dtype=float)
    known = inverse @ (gram - seen) @ inverse
    covariance = covariance_under(state, left, inverse, known)
    if not of_noise:
        slopes = {j: c[:, k:] for j, c in columns.items()}
        systematic = moved_by_reversals(state, index, slopes, np.diag(covariance))
        covariance = covariance + np.diag(systematic)
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return covariance[:k, :k], shape_errors_of(state, term, errors[k:])


def certain_before(term: Term, of_law: bool = True) -> Array:
    """(s,) one over the variance of each free shape that is known without any data: of the range
    of its law, what a law's exponent is. of_law: whether one law may as well be another; if not,
    what tells them apart is as it was found."""
    shapes = free_shapes(term.effect, term.shape)
    sure = [CHOSEN if s.of_law and not of_law else 1.0 for s in shapes]
    return 1.0 / np.square(np.array([s.spread for s in shapes]) * sure)


def shape_errors_of(state: SearchState, term: Term, errors: Array) -> dict[str, float]:
    """Of a term's free shapes, from their standard errors (s,) as the fit has them.

    Values that the columns blur together no noise could tell apart, however small it is; nor is a
    shape known better than the share of its torque that the data show. Of a rotor that is a share
    of all that turns in its joint: what is on the motor's side is not on the link's.
    """
    free, short = free_shapes(term.effect, term.shape), off_by(term)
    out = {}
    for s, error in zip(free, errors, strict=True):
        value = term.shape[s.name]
        whole = _turns(state, term) if s.name == ROTOR.name else value
        out[s.name] = float(np.hypot(error, np.hypot(s.blur * value, short * whole)))
    return out


def _turns(state: SearchState, term: Term) -> float:
    """kg·m² (kg) of a joint, over the poses of its arm."""
    return float(state.train.contexts[0].typical_inertia[term.joints[0]])


def off_by(term: Term) -> float:
    """By what share a torque that its shape alone would settle is more or less than it says."""
    kinds = zip(term.effect.coefficients, term.coefficients, strict=True)
    return max((abs(1.0 - float(c)) for kind, c in kinds if kind.whole_at_one), default=0.0)


def scales_of(state: SearchState, columns: PerJoint) -> tuple[Array, Array, Array]:
    """(n, k) N·m, the largest torque that a unit of each column makes in a sample of each joint;
    (n,) RMS of the joints' torque, and of what the fit leaves of it."""
    width = next(iter(columns.values())).shape[1]
    peaks = np.zeros((state.train.n, width))
    for j, x in columns.items():
        peaks[j] = np.abs(x).max(axis=0, initial=0.0)
    torque = [rms(t) for t in state.train.tau]
    return peaks, np.array(torque), state.fit.rms()


def covariance_under(
    state: SearchState, columns: PerJoint, turn: Array, known: Array | None
) -> Array:
    """(p, p) of estimates that weighted errors move by ``turn`` (p, k) times what weighted columns
    (m_j, k) see of them, as a model states it."""
    side, fit = state.train, state.fit
    left = side.scatter(fit.residual)
    stretches = [
        Stretch.of(run, residual * fit.sigma, keep)
        for run, keep, residual in zip(side.runs, side.keep, left, strict=True)
    ]
    spread = [side.spread(j, columns[j]) for j in range(side.n)]
    bases = [side.spread(j, fit.basis[j]) for j in range(side.n)]

    def seen() -> Iterator[list[WeightedStretch]]:
        for k, keep in enumerate(side.keep):
            yield [
                WeightedStretch(spread[j][k], partial(np.compress, keep[:, j], bases[j][k], axis=0))
                for j in range(side.n)
            ]

    turns, lowpass = [turn] * side.n, side.runs[0].lowpass
    return uncertainty(stretches, seen, turns, fit.sigma, fit.leverage(), lowpass, known).covariance


def _noises(side: Side, basis: PerJoint, residual: PerJoint) -> Noises:
    """Of a fit's basis under each joint's noise: weighted residuals (m_j,), taken as they are.

    Neither blocks of time nor what the fit took away count here: both make doubt of what is missing
    from the model, and that is what the search is for.
    """
    out = {}
    for j, left in residual.items():
        out[j] = ScoreVectors(Memory.of(side.stretches(j, left), side.runs[0].rate))
        for columns in side.spread(j, basis[j]):
            out[j].add(columns)
    return out
