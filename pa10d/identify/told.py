"""Shapes of further effects that a user asked for, refined beside all else of their joint.

The effect's own starting values stand a factor of two apart: left there, friction at low speed that
the model holds looks like an effect that it lacks. How smooth the joint's dry friction turns round
varies with them: a sign that was right for another bump would hold this one back. (It is found anew
afterwards, by its own rules.) What reversals make of an encoder's steps and of a sampled sign would
bend both, so only samples clear of them count, as in a diagnosis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.effects.base import ShapeParameter
from pa10d.identify.blocks import Pieces
from pa10d.identify.smoothing import COARSE, WIDEST
from pa10d.model import Term
from pa10d.regression.layout import Layout, has_sign
from pa10d.regression.spectrum import colour

Array = NDArray[np.float64]
Errors = dict[int, dict[str, float]]

EVALUATIONS = 30  # of the torque beside its derivatives
STARTS = 4  # from where it is sought: a bump and a sign that hold each other back end elsewhere
CLEAR = 16.0  # squared error, in units of one independent sample, that tells a wave from a bump
SURE = 1e-9  # of the largest singular value, from which on a direction is one


def refined(layout: Layout, pieces: Pieces) -> tuple[Layout, Errors]:
    """The layout with the best shape of every effect of one joint that was asked for, and by index
    of the term the standard errors of its shape (inf: the data do not tell it)."""
    errors: Errors = {}
    for index, term in enumerate(layout.terms):
        if term.effect.question == "textbook" or len(term.joints) != 1 or not _free(term):
            continue
        own = _Equation(layout, pieces, index)
        found, doubts = own.solve()
        layout = layout.with_shapes({index: found.shape})
        errors[index] = doubts
        pieces.forget_columns()
    return layout, errors


def _free(term: Term) -> list[ShapeParameter]:
    return [s for s in term.effect.shapes if s.scale != "choice" and s.name in term.shape]


def _with_sign(term: Term, v0: float) -> Term:
    return replace(term, shape={**term.shape, term.effect.smoothed_over: float(v0)})


class _Equation:
    """One joint's own equation, its other terms solved (variable projection)."""

    def __init__(self, layout: Layout, pieces: Pieces, index: int) -> None:
        self._joint = joint = layout.terms[index].joints[0]
        here = [i for i, t in enumerate(layout.terms) if t.touches(joint)]
        places = [index, *(i for i in here if has_sign(layout.terms[i], joint) and i != index)]
        self._terms = [layout.terms[i] for i in places]
        others = [layout.terms[i] for i in here if i not in places]
        widest = float(np.clip(WIDEST * pieces.fast[joint], COARSE[1], COARSE[-1]))
        self._signs = (float(COARSE[0]), widest)
        self._pieces, self._rate = list(pieces.some()), pieces.rate
        self._masks = [piece.keep[:, joint] for piece in self._pieces]
        rows = [
            np.column_stack([p.rigid[joint], p.filtered(others, joint)])[keep]
            for p, keep in zip(self._pieces, self._masks, strict=True)
        ]
        self._basis = _basis(np.concatenate(rows))
        tau = [p.tau[k, joint] for p, k in zip(self._pieces, self._masks, strict=True)]
        self._torque = self._beyond(np.concatenate(tau)[:, None])[:, 0]

    def solve(self) -> tuple[Term, dict[str, float]]:
        """The term in the shape that leaves least, and its standard errors by how fast the torque
        changes with it; correlated samples of what is left count as few."""
        free = [(k, s) for k, t in enumerate(self._terms) for s in _free(t)]
        bounds = [(s.lower, s.upper) if k == 0 else self._signs for k, s in free]
        log = np.array([s.scale == "log" or k > 0 for k, s in free])

        def shaped(begun: list[Term], x: Array) -> list[Term]:
            values = np.where(log, np.exp(np.where(log, x, 0.0)), x)
            shapes = [dict(t.shape) for t in begun]
            for (k, s), value in zip(free, values, strict=True):
                shapes[k][s.name] = float(value)
            return [replace(t, shape=shape) for t, shape in zip(begun, shapes, strict=True)]

        def on_scale(values: Sequence[float]) -> Array:
            given = np.asarray(values, dtype=np.float64)
            return np.where(log, np.log(np.maximum(given, 1e-12)), given)

        low, high = on_scale([b[0] for b in bounds]), on_scale([b[1] for b in bounds])
        room = 1e-6 * (high - low)

        def from_there(terms: list[Term]) -> scipy.optimize.OptimizeResult:
            start = on_scale([terms[k].shape[s.name] for k, s in free])
            return scipy.optimize.least_squares(
                lambda x: self._left(shaped(terms, x)),
                np.clip(start, low + room, high - room),
                bounds=(low, high),
                x_scale=np.where(log, 1.0, np.maximum(np.abs(start), 1e-3)),
                diff_step=1e-3,
                max_nfev=EVALUATIONS,
            )

        ends = [(from_there(begun), begun) for begun in self._starts()]
        solved, begun = min(ends, key=lambda end: float(end[0].cost))
        enough = 0.5 * CLEAR * self._unit(solved.fun) + float(solved.cost)
        near = [end for end in ends if float(end[0].cost) <= enough]
        solved, begun = min(near, key=lambda end: (self._choices(end[1]), float(end[0].cost)))
        term = shaped(begun, solved.x)[0]
        spread = self._spread(solved.jac, solved.fun)
        unit = np.where(log, np.exp(np.where(log, solved.x, 0.0)), 1.0)
        doubts = {
            s.name: float(error)
            for (k, s), error in zip(free, spread * unit, strict=True)
            if k == 0
        }
        return term, doubts

    def _starts(self) -> list[list[Term]]:
        """Where to begin: as they are, and the best of the effect's own starts and coarse signs."""
        own, *signs = self._terms
        shapes = own.effect.starts(self._pieces[0].context, own.joints)
        least, most = self._signs
        sharp = [v for v in COARSE if least <= v <= most] if signs else [0.0]
        trials = [
            [replace(own, shape=dict(shape)), *(_with_sign(t, v) for t in signs)]
            for shape in shapes
            for v in sharp
            if shape.keys() == own.shape.keys()
        ]
        trials.sort(key=lambda terms: float(np.sum(self._left(terms) ** 2)))
        best: dict[tuple[float, ...], list[Term]] = {}
        for terms in trials:  # a bump or a wave: none is left out because others begin nearer
            best.setdefault(self._choices(terms), terms)
        others = [terms for terms in trials if not any(terms is b for b in best.values())]
        return [self._terms, *best.values(), *others[: max(0, STARTS - 1 - len(best))]]

    def _choices(self, terms: list[Term]) -> tuple[float, ...]:
        """What is chosen of the told effect, the plainer first: a bump is 0, a wave 1."""
        kinds = [s.name for s in terms[0].effect.shapes if s.scale == "choice"]
        return tuple(terms[0].shape.get(name, 0.0) for name in kinds)

    def _left(self, terms: list[Term]) -> Array:
        found = [
            piece.filtered(terms, self._joint)[keep]
            for piece, keep in zip(self._pieces, self._masks, strict=True)
        ]
        inside = _basis(self._beyond(np.concatenate(found)))
        return np.asarray(self._torque - inside @ (inside.T @ self._torque))

    def _beyond(self, rows: Array) -> Array:
        return np.asarray(rows - self._basis @ (self._basis.T @ rows))

    def _spread(self, jac: Array, left: Array) -> Array:
        size = np.linalg.norm(jac, axis=0)
        if np.any(size <= SURE * np.linalg.norm(left)):
            return np.full(jac.shape[1], np.inf)
        values, vectors = np.linalg.eigh((jac / size).T @ (jac / size))
        if values[0] <= SURE:
            return np.full(jac.shape[1], np.inf)
        return np.asarray(np.sqrt(self._unit(left) * np.sum(vectors**2 / values, axis=1)) / size)

    def _unit(self, left: Array) -> float:
        """Squared error of one independent sample."""
        stretches, at = [], 0
        for keep in self._masks:
            whole, count = np.zeros(len(keep)), int(keep.sum())
            whole[keep] = left[at : at + count]
            stretches.append((whole, keep))
            at += count
        gamma = colour(stretches, self._rate)
        inflation = 1.0 + 2.0 * float(gamma[1:].sum()) / max(float(gamma[0]), 1e-300)
        return max(inflation, 1.0) * float(left @ left) / max(1, len(left))


def _basis(rows: Array) -> Array:
    """(M, r) an orthonormal basis of what columns (M, k) span."""
    scale = np.linalg.norm(rows, axis=0)
    return np.asarray(scipy.linalg.orth(rows / np.where(scale > 0.0, scale, 1.0), rcond=SURE))
