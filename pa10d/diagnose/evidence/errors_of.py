"""Standard errors of a term's coefficients and shapes under autocorrelated noise."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.diagnose.constants import LONGEST_MEMORY
from pa10d.diagnose.evidence.held_out import Doubt
from pa10d.diagnose.evidence.reversals import moved_by_reversals
from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.partial import normal_equations
from pa10d.diagnose.regression.shapes import free_shapes
from pa10d.diagnose.regression.side import PerJoint, Side
from pa10d.diagnose.regression.slopes import with_slopes
from pa10d.diagnose.regression.state import SearchState
from pa10d.effects import Value
from pa10d.regression.lacking import Stretch, lacking, weight_of
from pa10d.regression.spectrum import colour, coloured_gram
from pa10d.regression.suspects import Suspects, Tally, worst
from pa10d.regression.told import added_ones, left_open, names_of

Array = NDArray[np.float64]


def full_covariance(
    state: SearchState, fit: LeastSquares | None = None, noise: PerJoint | None = None
) -> Array:
    """(p, p) of all coefficients: (XᵀX)⁻¹ XᵀΣX (XᵀX)⁻¹ with Σ from the residuals themselves.

    fit: another one of the same columns, some of them left out; noise: weighted residuals (m_j,)
    that know more than its own.
    """
    fit = state.fit if fit is None else fit
    return _covariance(state, fit, noise_grams(state.train, noise or fit.residual, fit.basis))


def honest_covariance(state: SearchState) -> Array:
    """(p, p) of all coefficients as a model states them: what it lacks itself included. The search
    asks whether there is more than noise; who reads a model asks how far off it may be."""
    fit = state.fit
    grams = noise_grams(state.train, fit.residual, fit.basis)
    return _covariance(state, fit, grams) + _of_lack(state, fit.basis, fit.to_beta)


@dataclass(frozen=True)
class Doubts:
    """How uncertain the present model is on the held-out side, whatever is added to it.

    What is missing from a model colours its residual, and noise is only what would be left without
    it. So each joint's noise is what its best candidate leaves, and for a candidate under
    judgement what that one leaves on the joints on which it acts. On data with nothing hidden the
    best of many candidates takes next to nothing away.
    """

    state: SearchState
    grams: dict[int, Array]

    @classmethod
    def of(cls, state: SearchState, changes: Iterable[PerJoint]) -> Doubts:
        """changes: what each candidate changes on the fit side (weighted), on its own joints."""
        left = dict(state.fit.residual)
        for change in changes:
            for j, moved in change.items():
                rest = state.fit.residual[j] - moved
                if rest @ rest < left[j] @ left[j]:
                    left[j] = rest
        return cls(state, noise_grams(state.train, left, state.fit.basis))

    def beside(self, change: PerJoint) -> Doubt:
        """With a candidate added that changes the fit side so."""
        fit = self.state.fit
        left = {j: fit.residual[j] - moved for j, moved in change.items()}
        own = noise_grams(self.state.train, left, {j: fit.basis[j] for j in left})
        covariance = _covariance(self.state, fit, {**self.grams, **own})
        return Doubt(self.state.held_matrix, covariance)


def doubt_under(state: SearchState, grams: dict[int, Array]) -> Doubt:
    """How uncertain the model is on the held-out side, with each joint's noise given as
    ``held_noise_gram`` has it."""
    return Doubt(state.held_matrix, _covariance(state, state.fit, grams))


def held_noise_gram(
    state: SearchState, joint: int, noise: Array, heard: NDArray[np.bool_]
) -> Array:
    """QᵀΓQ of the fit side with a joint's noise as the held-out side has it.

    noise: (m_j,) N·m held out; heard: the samples of it that count. What bends so freely that it
    takes noise along leaves too little of it on the side it was fitted to, but not here.
    """
    rows = state.held.scatter({joint: noise / state.fit.sigma[joint]})
    there = state.held.scatter({joint: heard.astype(float)})
    keep = [t[:, joint] > 0 for t in there]
    stretches = [(r[:, joint], k) for r, k in zip(rows, keep, strict=True)]
    gamma = _colour(stretches, state.held.runs[0].rate)
    return _coloured(state.train, joint, state.fit.basis[joint], gamma)


def doubt_of(
    state: SearchState, fit: LeastSquares | None = None, noise: PerJoint | None = None
) -> Doubt:
    """How uncertain the model is on the held-out side."""
    return Doubt(state.held_matrix, full_covariance(state, fit, noise))


def moved_by_doubt(state: SearchState, level: float) -> Array:
    """(n,) N·m RMS that the uncertainty of the model's own coefficients leaves on the held-out side
    of each joint, exceeded by chance in a share ``level`` of cases only: a sum of squares of
    normal numbers with the variances of the prediction, taken for a χ² (Satterthwaite 1946)."""
    covariance, out = full_covariance(state), np.zeros(state.held.n)
    for j, x in state.held_matrix.items():
        spread = covariance @ (x.T @ x) / max(len(x), 1)
        mean, square = float(np.trace(spread)), float(np.sum(spread * spread.T))
        if mean > 0.0 and square > 0.0:
            out[j] = np.sqrt(square / mean * scipy.stats.chi2.isf(level, mean**2 / square))
    return out


def _covariance(state: SearchState, fit: LeastSquares, grams: dict[int, Array]) -> Array:
    middle = np.sum(list(grams.values()), axis=0)
    if state.knowledge is not None:
        # what was known already is as certain as it said
        top = np.sum([q.T @ q for q in fit.basis.values()], axis=0)
        middle = middle + np.eye(len(top)) - top
    return np.asarray(fit.to_beta @ middle @ fit.to_beta.T)


def term_covariance(state: SearchState, index: int) -> tuple[Array, dict[str, float]]:
    """Covariance (k, k) of a term's coefficients with its shape free, and the shape's errors."""
    term = state.terms[index]
    place = state.place(index)
    free = free_shapes(term.effect, term.shape)
    rest = state.fit.without(place)
    columns = with_slopes(state.train, term) if free else dict(state.blocks[index][0])
    k = len(term.coefficients)
    left: PerJoint = {}
    seen = sum(rest.basis[j].T @ (c / rest.sigma[j]) for j, c in columns.items())
    for j in range(state.train.n):
        own = columns.get(j)
        absorbed = rest.basis[j] @ seen
        left[j] = -absorbed if own is None else own / rest.sigma[j] - absorbed
    gram = sum(c.T @ c for c in left.values())
    if state.knowledge is not None:
        gram, _ = normal_equations(rest, columns)
        penalty = term.effect.penalty(term.shape)
        if penalty is not None:
            gram = gram + penalty.T @ penalty
    inverse = np.linalg.pinv(gram, rcond=1e-12, hermitian=True)
    grams = noise_grams(state.train, state.fit.residual, left)
    middle = np.sum(list(grams.values()), axis=0)
    covariance = inverse @ middle @ inverse + _of_lack(state, left, np.asarray(inverse))
    if state.knowledge is not None:
        covariance = covariance + inverse @ (gram - sum(c.T @ c for c in left.values())) @ inverse
    slopes = {j: c[:, k:] for j, c in columns.items()}
    systematic = moved_by_reversals(state, index, slopes, np.diag(covariance))
    covariance = covariance + np.diag(systematic)
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    shape_errors = {
        # values that the columns blur together no noise could tell apart, however small it is
        s.name: float(np.hypot(e, s.blur * term.shape[s.name]))
        for s, e in zip(free, errors[k:], strict=True)
    }
    return covariance[:k, :k], shape_errors


def told(
    state: SearchState, index: int, covariance: Array, shape_errors: dict[str, float]
) -> dict[str, Value]:
    """A term's parameters, what the data leave open among them; arguments: ``term_covariance``."""
    term = state.terms[index]
    values = term.effect.values(term.coefficients, covariance, term.shape, shape_errors)
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    added = added_ones(0, [term])
    scales = scales_of(state, state.blocks[index][0])
    names = [coefficient.name for coefficient in term.effect.coefficients]
    for name in names_of(names, left_open(term.coefficients, errors, *scales, added)):
        if name in values:
            values[name] = replace(values[name], determined=False)
    return values


def scales_of(state: SearchState, columns: PerJoint) -> tuple[Array, Array, Array]:
    """(n, k) N·m, the largest torque that a unit of each column makes in a sample of each joint;
    (n,) RMS of the joints' torque, and of what the fit leaves of it."""
    width = next(iter(columns.values())).shape[1]
    peaks = np.zeros((state.train.n, width))
    for j, x in columns.items():
        peaks[j] = np.abs(x).max(axis=0, initial=0.0)
    torque = [float(np.sqrt(np.mean(t**2))) if len(t) else 0.0 for t in state.train.tau]
    return peaks, np.array(torque), state.fit.rms()


def _of_lack(state: SearchState, columns: PerJoint, turn: Array) -> Array:
    """(p, p) how far what the model lacks may move ``turn`` (p, k) times what weighted columns
    (m_j, k) see of the torque (see ``lacking`` and ``suspects``)."""
    side, sigma, fit = state.train, state.fit.sigma, state.fit
    there = side.scatter(fit.residual)
    stretches = [
        Stretch.of(run, residual * sigma, keep)
        for run, keep, residual in zip(side.runs, side.keep, there, strict=True)
    ]
    samples = np.sum([k.sum(axis=0) for k in side.keep], axis=0).astype(float)
    lack = lacking(stretches, side.runs[0].lowpass)
    weight = weight_of(lack, samples) / sigma**2
    suspects, whole = Suspects(stretches), np.zeros((len(turn), len(turn)))
    for j in (j for j in range(side.n) if lack[j] > 0.0):
        tally, start = Tally(), 0
        for stretch in stretches:
            rows = slice(start, start + int(stretch.keep[:, j].sum()))
            residual = fit.residual[j][rows] * sigma[j]
            tally.add(suspects.families(stretch, j), fit.basis[j][rows], residual, columns[j][rows])
            start = rows.stop
        found = [d / sigma[j] ** 2 for d in tally.doubts(float(lack[j]))]
        anything = weight[j] * (columns[j].T @ columns[j])
        whole += worst([turn @ doubt @ turn.T for doubt in (anything, *found)])
    return whole


def noise_grams(side: Side, residual: PerJoint, columns: PerJoint) -> dict[int, Array]:
    """joint -> Cᵀ Γ_j C for weighted columns and the whitened residual's autocovariance Γ_j."""
    return {j: _noise_gram(side, j, residual[j], c) for j, c in columns.items()}


def _noise_gram(side: Side, joint: int, residual: Array, columns: Array) -> Array:
    scattered = side.scatter({joint: residual})
    stretches = [(r[:, joint], k[:, joint]) for r, k in zip(scattered, side.keep, strict=True)]
    return _coloured(side, joint, columns, _colour(stretches, side.runs[0].rate))


def _colour(stretches: list[tuple[Array, NDArray[np.bool_]]], rate: float) -> Array:
    longest = int(min(LONGEST_MEMORY * rate, min(len(k) for _, k in stretches) // 4))
    return colour(stretches, longest)


def _coloured(side: Side, joint: int, columns: Array, gamma: Array) -> Array:
    total, start = np.zeros((columns.shape[1], columns.shape[1])), 0
    for run_keep in side.keep:
        k = run_keep[:, joint]
        rows = int(k.sum())
        spread = np.zeros((len(k), columns.shape[1]))
        spread[k] = columns[start : start + rows]
        total += coloured_gram(spread, gamma)
        start += rows
    return total
