"""The model at a step of the search: its terms, its columns on both sides, its fit."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.regression.least_squares import (
    LeastSquares,
    Prior,
    iterated_fit,
    predict,
    weighted_fit,
)
from pa10d.diagnose.regression.majority import agreed
from pa10d.diagnose.regression.side import PerJoint, Side
from pa10d.effects import Effect
from pa10d.model import Term, TorqueModel, Unknowns, vector_of

Array = NDArray[np.float64]


@dataclass
class SearchState:
    """Fit and held-out side of one model; columns are kept, so a step computes only new ones."""

    model: TorqueModel
    train: Side
    held: Side
    rigid: tuple[PerJoint, PerJoint]
    terms: list[Term]
    blocks: list[tuple[PerJoint, PerJoint]] = field(default_factory=list)
    fit: LeastSquares = None  # type: ignore[assignment]
    held_matrix: PerJoint = field(default_factory=dict)
    prior: Prior | None = None
    weights: Array | None = None  # σ per joint where it is not to follow the residual
    loads: Array | None = None  # base parameters of the model that the columns look at

    @classmethod
    def start(
        cls, model: TorqueModel, train: Side, held: Side, frozen: bool = False
    ) -> SearchState:
        """Columns of the given model, refitted to the training side.

        frozen: the model may move only as far as its own uncertainty allows.
        """
        train.look_through(model)
        held.look_through(model)
        kept = model.base.kept
        state = cls(model, train, held, (train.rigid(kept), held.rigid(kept)), [])
        state.prior = own_uncertainty(model) if frozen else None
        for term in model.terms:
            state.push(term)
        state.refit()
        state.relook()
        if any(term.effect.uses_model for term in state.terms):
            state.refit()
        return state

    @property
    def knowledge(self) -> Prior | None:
        """What the fit knows of the coefficients besides the data: a frozen model's own
        uncertainty, else how smooth its maps are."""
        return self.prior or smoothness(self.unknowns)

    @property
    def drawn_by_loads(self) -> bool:
        """Do terms throw the links about by loads of the model itself, as gaps and springs do?"""
        return any(t.effect.uses_model and t.effect.reaches_other_joints for t in self.terms)

    def may_fall(self, effect: Effect) -> bool:
        """Is the effect sought as a change of what a frozen model has already?"""
        return self.prior is not None and effect.question == "textbook"

    def push(self, term: Term) -> None:
        """Append a term; the caller refits."""
        self.terms.append(term)
        self.blocks.append(self._columns(term))

    def replace_term(self, index: int, term: Term) -> None:
        """Another shape for a term; the caller refits."""
        self.terms[index] = term
        self.blocks[index] = self._columns(term)

    def drop(self, index: int) -> None:
        """Remove a term; the caller refits."""
        del self.terms[index], self.blocks[index]

    def copy(self) -> SearchState:
        """As it is now: going on with one of the two leaves the other alone."""
        return replace(
            self,
            train=copy(self.train),
            held=copy(self.held),
            terms=list(self.terms),
            blocks=list(self.blocks),
        )

    def bare(self, count: int, own_weights: bool = False) -> SearchState:
        """A refitted copy with the first ``count`` terms only.

        own_weights: joints are weighted with what this smaller model leaves, as they would be had
        nobody ever seen the terms that it lacks.
        """
        copy = replace(self, terms=self.terms[:count], blocks=self.blocks[:count])
        if own_weights:
            copy.fit = None  # type: ignore[assignment]
        copy.refit()
        return copy

    @property
    def unknowns(self) -> Unknowns:
        """What stands where in the coefficients of the model at hand."""
        return Unknowns(self.model.base, tuple(self.terms))

    def place(self, index: int) -> slice:
        """Columns of terms[index] in the matrix."""
        return self.unknowns.places[index]

    def refit(self) -> None:
        """Solve for all coefficients and hand them to the terms and the model."""
        if self.weights is not None:
            self.fit = weighted_fit(self.train, self.matrix(0), self.weights, self.knowledge)
        else:
            sigma = None if self.fit is None else self.fit.rms()
            self.fit = iterated_fit(self.train, self.matrix(0), sigma, self.knowledge)
        self.held_matrix = self.matrix(1)
        self.model = self.with_coefficients(self.fit.beta)
        self.terms = list(self.model.terms)

    def relook(self) -> None:
        """Loads have changed: columns that depend on the model are made again.

        Loads are those of the coefficients that most samples agree on; a model that brings its
        own knowledge is not bent by a few samples anyway.
        """
        if self.prior is None:
            model = replace(self.with_coefficients(agreed(self.fit)), loads=None)
            self.loads = model.h
        else:
            model = self.model
        self.train.look_through(model)
        self.held.look_through(model)
        for index, term in enumerate(self.terms):
            if term.effect.uses_model:
                self.blocks[index] = self._columns(term)

    def matrix(self, side: int) -> PerJoint:
        """All columns of one side (0 training, 1 held out), joint -> (m_j, p)."""
        unknowns, out = self.unknowns, {}
        for j, rows in self.rigid[side].items():
            out[j] = np.zeros((len(rows), unknowns.size))
            out[j][:, : len(self.model.h)] = rows
            for columns, place in zip(self.blocks, unknowns.places, strict=True):
                if j in columns[side]:
                    out[j][:, place] = columns[side][j]
        return out

    def held_residual(self, fit: LeastSquares | None = None) -> PerJoint:
        """joint -> (m_j,) N·m left over on the held-out side."""
        predicted = predict(self.held_matrix, (fit or self.fit).beta)
        return {j: self.held.tau[j] - predicted[j] for j in predicted}

    def rms_of(self, beta: Array) -> Array:
        """(n,) N·m that other values of the coefficients leave on the training side."""
        torque = predict(self.matrix(0), beta)
        left = [self.train.tau[j] - torque[j] for j in range(self.train.n)]
        return np.array([float(np.sqrt(np.mean(r**2))) for r in left])

    def train_residual(self) -> PerJoint:
        """joint -> (m_j,) N·m left over on the training side."""
        return {j: r * self.fit.sigma[j] for j, r in self.fit.residual.items()}

    def moving_rms(self) -> Array:
        """(n,) N·m on the held-out side, reversals included: what a fit has not looked at must not
        become worse either."""
        squares, counts = np.zeros(self.held.n), np.zeros(self.held.n)
        for run in self.held.runs:
            error = run.tau - run.lowpass(self.model.predict(run.context))
            near = run.moving
            squares += np.sum(np.where(near, error, 0.0) ** 2, axis=0)
            counts += near.sum(axis=0)
        return np.asarray(np.sqrt(squares / np.maximum(counts, 1)))

    def change(self, fit: LeastSquares, columns: PerJoint, seen: Array, theta: Array) -> PerJoint:
        """What adding a candidate changes on the held-out side, the model refitted around it.

        columns: of the candidate on the held-out side; seen: what ``fit`` absorbs of it.
        """
        moved = predict(self.held_matrix, -(fit.to_beta @ (seen @ theta)))
        for j, c in columns.items():
            moved[j] = moved[j] + c @ theta
        return moved

    def with_coefficients(self, beta: Array) -> TorqueModel:
        """The model with its terms and these coefficients."""
        unknowns = self.unknowns
        return replace(
            self.model,
            h=unknowns.rigid(beta),
            terms=unknowns.fitted(beta),
            covariance=self.fit.covariance(),
            loads=self.loads if self.drawn_by_loads else None,
        )

    def _columns(self, term: Term) -> tuple[PerJoint, PerJoint]:
        return (
            self.train.columns(term.effect, term.joints, [term.shape]),
            self.held.columns(term.effect, term.joints, [term.shape]),
        )


def smoothness(unknowns: Unknowns) -> Prior | None:
    """Penalties of all terms that have one."""
    rows = []
    for term, place in zip(unknowns.terms, unknowns.places, strict=True):
        penalty = term.effect.penalty(term.shape)
        if penalty is not None:
            rows.append(np.zeros((len(penalty), unknowns.size)))
            rows[-1][:, place] = penalty
    return Prior(np.zeros(unknowns.size), np.concatenate(rows)) if rows else None


def own_uncertainty(model: TorqueModel) -> Prior:
    """The model's coefficients as prior knowledge with their own covariance.

    Directions that its data never showed have no variance to speak of in the covariance (they
    were truncated) and stay where they are.
    """
    mean = vector_of(model.h, model.terms)
    scale = np.sqrt(np.maximum(np.diag(model.covariance), 1e-300))
    scale = np.maximum(scale, 1e-9 * max(float(np.max(scale)), 1e-9))
    values, vectors = np.linalg.eigh(model.covariance / np.outer(scale, scale))
    values = np.maximum(values, 1e-8 * float(values[-1]))
    return Prior(mean, (vectors / np.sqrt(values)).T / scale)
