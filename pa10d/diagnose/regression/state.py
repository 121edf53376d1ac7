"""The model at a step of the search: its terms, its columns on both sides, its fit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.diagnose.constants import OWN_LEVEL, OWN_ROUNDS, OWN_STEP
from pa10d.diagnose.regression.least_squares import LeastSquares, solved
from pa10d.diagnose.regression.majority import agreed
from pa10d.diagnose.regression.side import Side
from pa10d.effects import Effect
from pa10d.measurement.torque_filter import TorqueFilter
from pa10d.model import Term, TorqueModel, Unknowns, vector_of
from pa10d.regression.bodies import widely
from pa10d.regression.per_joint import Mask, PerJoint, assembled, predict, rms
from pa10d.regression.problem import Knowledge, LinearProblem
from pa10d.regression.winding import seen_by

Array = NDArray[np.float64]
Suspects = Sequence[tuple[Effect, tuple[int, ...]]]
"""What may be missing or have changed, and on which joints (0-based)."""


@dataclass
class SearchState:
    """A problem as far as it has come, and the work on it.

    Problem and sides are constant: a step puts others in their place, and whoever holds the old
    ones keeps them. Columns are kept, so a step computes only new ones.
    """

    problem: LinearProblem[Unknowns]
    model: TorqueModel
    train: Side
    held: Side
    rigid: tuple[PerJoint, PerJoint]
    blocks: list[tuple[PerJoint, PerJoint]] = field(default_factory=list)
    fit: LeastSquares = None  # type: ignore[assignment]
    held_matrix: PerJoint = field(default_factory=dict)
    loads: Array | None = None  # base parameters of the model that the columns look at
    loads_apart: bool = False  # these are not those of its own coefficients
    usual: Array | None = None  # (n,) N·m RMS that a frozen model may leave though nothing changed
    as_given: Array | None = None  # (n,) N·m RMS that it leaves held out as it was
    heeding: frozenset[tuple[str, tuple[int, ...]]] = frozenset()  # effects, joints: terms of whose
    # shape reversals on the fit side, too, are asked
    none_at_least: bool = False  # of what no joint has less of than none, none is held at none
    free: LeastSquares | None = None  # the fit without that, where it makes a difference

    @classmethod
    def start(
        cls,
        model: TorqueModel,
        train: Side,
        held: Side,
        frozen: bool = False,
        firmness: float = 1.0,
        none_at_least: bool = False,
    ) -> SearchState:
        """Columns of the given model, refitted to the training side.

        frozen: the model may move only as far as its own uncertainty allows, or one ``firmness``
        times smaller.
        """
        kept = model.base.kept
        prior = own_uncertainty(model, firmness) if frozen else None
        bodies = None if frozen else bodies_of(model)
        problem = LinearProblem(Unknowns(model.base, ()), prior, bodies=bodies)
        train, held = train.through(model), held.through(model)
        state = cls(problem, model, train, held, (train.rigid(kept), held.rigid(kept)))
        state.none_at_least = none_at_least
        for term in model.terms:
            state.push(term)
        state.refit()
        state.relook()
        if any(term.effect.uses_model for term in state.terms):
            state.refit()
        return state.where_shared_slips()

    @property
    def unknowns(self) -> Unknowns:
        """What stands where in the coefficients of the model at hand."""
        return self.problem.unknowns

    @property
    def terms(self) -> tuple[Term, ...]:
        """Of the model at hand."""
        return self.problem.terms

    @property
    def frozen(self) -> bool:
        """May the model move only as far as its own uncertainty allows?"""
        return self.problem.prior is not None

    @property
    def drawn_by_loads(self) -> bool:
        """Do terms throw the links about by loads of the model itself, as gaps and springs do?"""
        return any(t.effect.uses_model and t.effect.reaches_other_joints for t in self.terms)

    def may_fall(self, effect: Effect) -> bool:
        """Is the effect sought as a change of what a frozen model has already?"""
        return self.frozen and effect.question == "textbook"

    def same_before(self, effect: Effect, joints: Sequence[int]) -> Term | None:
        """What a frozen model has there already, where all of its shape is how sharp a corner is:
        what changed is how much of it there is. None: the shape is open."""
        if not (self.may_fall(effect) and all(s.smoothing or s.optional for s in effect.shapes)):
            return None
        there = (
            t for t in self.model.terms if (t.effect_id, t.joints) == (effect.id, tuple(joints))
        )
        return next(there, None)

    def push(self, term: Term) -> None:
        """Append a term; the caller refits."""
        self.problem = self.problem.with_terms([*self.terms, term])
        self.blocks.append(self._columns(term))

    def replace_term(self, index: int, term: Term) -> None:
        """Another shape for a term; the caller refits."""
        self.problem = self.problem.with_term(index, term)
        self.blocks[index] = self._columns(term)

    def drop(self, index: int) -> None:
        """Remove a term; the caller refits. What it had taken over is there again."""
        self._give_back(self.terms[index])
        self.problem = self.problem.with_terms([*self.terms[:index], *self.terms[index + 1 :]])
        del self.blocks[index]

    def _give_back(self, gone: Term) -> None:
        """Dry friction that bristles had taken over turns round at once again."""
        for index, term in enumerate(self.terms):
            taken = gone.effect.builds_up_over and term.joints == gone.joints
            if taken and "elsewhere" in term.shape:
                shape = {name: v for name, v in term.shape.items() if name != "elsewhere"}
                self.replace_term(index, replace(term, shape=shape))

    def behind(self, channel: TorqueFilter | None) -> SearchState:
        """A refitted copy of which all columns pass such a torque channel (None: they pass as they
        are)."""
        train, held = self.train.behind(channel), self.held.behind(channel)
        return replace(self, model=replace(self.model, channel=channel))._of(train, held)

    def where_shared_slips(self) -> SearchState:
        """A refitted copy without moments in which what its terms let joints share sticks; itself
        where those are what it leaves out."""
        train, held = (side.where_shared_slips(self.terms) for side in (self.train, self.held))
        sides = zip((train, held), (self.train, self.held), strict=True)
        if all(_same_samples(one, other) for one, other in sides):
            return self
        return self._of(train, held)

    def _of(self, train: Side, held: Side) -> SearchState:
        """A refitted copy with other sides."""
        kept = self.model.base.kept
        copy = replace(self, train=train, held=held, rigid=(train.rigid(kept), held.rigid(kept)))
        copy.blocks = [copy._columns(term) for term in self.terms]
        copy.refit()
        return copy

    def where(self, keep: tuple[Sequence[Mask], Sequence[Mask]]) -> SearchState:
        """A refitted copy that looks at these samples alone, (M, n) per run of either side."""
        train, held = self.train.where(keep[0]), self.held.where(keep[1])
        rows = [old.rows_within(new) for old, new in ((self.train, train), (self.held, held))]

        def seen(columns: tuple[PerJoint, PerJoint]) -> tuple[PerJoint, PerJoint]:
            first, second = (
                {j: c[within[j]] for j, c in of_side.items()}
                for of_side, within in zip(columns, rows, strict=True)
            )
            return first, second

        copy = replace(self, train=train, held=held, rigid=seen(self.rigid))
        copy.blocks = [seen(columns) for columns in self.blocks]
        copy.refit()
        return copy

    def weigh(self, sigma: Array | None) -> None:
        """Weight joints by 1/σ² (None: by what the fit leaves of each); the caller refits."""
        self.problem = replace(self.problem, sigma=sigma)

    def copy(self) -> SearchState:
        """As it is now: going on with one of the two leaves the other alone."""
        return replace(self, blocks=list(self.blocks))

    def bare(self, count: int, own_weights: bool = False) -> SearchState:
        """A refitted copy with the first ``count`` terms only.

        own_weights: joints are weighted with what this smaller model leaves, as they would be had
        nobody ever seen the terms that it lacks.
        """
        problem = self.problem.with_terms(self.terms[:count])
        copy = replace(self, problem=problem, blocks=self.blocks[:count])
        for term in self.terms[count:]:
            copy._give_back(term)
        if own_weights:
            copy.fit = None  # type: ignore[assignment]
        copy.refit()
        return copy

    def place(self, index: int) -> slice:
        """Columns of terms[index] in the matrix."""
        return self.unknowns.places[index]

    def refit(self) -> None:
        """Solve for all coefficients and hand them to the terms and the model."""
        start = None if self.fit is None else self.fit.rms()
        self.fit = solved(self.train, self.matrix(0), self.problem, start)
        self.fit = self._within_its_doubt(lambda fit: fit)
        self.free = None
        if self.none_at_least:
            self._hold_at_none()
        self.held_matrix = self.matrix(1)
        self.model = self.with_coefficients(self.fit.beta)
        self.problem = self.problem.with_terms(self.model.terms)

    def below_none(self, fit: LeastSquares | None = None) -> list[int]:
        """Indices of the textbook's terms of which a fit wants less than none."""
        beta = (fit or self.fit).beta
        return [k for k in self._of_textbook() if np.any(beta[self.place(k)] < 0.0)]

    def at_none(self) -> list[int]:
        """Indices of the textbook's terms that are held at none."""
        textbook = [] if self.free is None else self._of_textbook()
        return [k for k in textbook if not np.any(self.fit.beta[self.place(k)])]

    def _of_textbook(self) -> list[int]:
        """Indices of its terms of which no joint has less than none."""
        return [
            index
            for index, term in enumerate(self.terms)
            if term.effect.question == "textbook"
            and all(c.lower == 0.0 for c in term.effect.coefficients)
        ]

    def _hold_at_none(self) -> None:
        fit, held = self.fit, set[int]()
        while below := {*self.below_none(fit)} - held:
            held |= below
            for index in below:
                fit = fit.without(self.place(index))
        if not held:
            return
        for index in held:
            fit.beta[self.place(index)] = 0.0  # but for rounding, it is
        free, self.free = self.fit, self.fit
        # which bodies can be is asked of all columns
        self.fit = replace(fit, triangle=free.triangle, target=free.target)

    def as_free(self) -> SearchState:
        """The same with the fit that may want less than none: what is held at none is known no
        better for that."""
        return self if self.free is None else replace(self, fit=self.free)

    def fit_without(self, index: int) -> LeastSquares:
        """The same without terms[index], all else solved anew."""
        place = self.place(index)
        return self._within_its_doubt(lambda fit: fit.without(place))

    def _within_its_doubt(self, seen: Callable[[LeastSquares], LeastSquares]) -> LeastSquares:
        """What is ``seen`` of the fit, of a frozen model no farther away than its own uncertainty:
        thousands of samples would pull it beyond, to where it imitates what has changed."""
        fit, own, stiff = seen(self.fit), self.problem.prior, 1.0
        if own is None:
            return fit
        farthest = float(scipy.special.chdtri(len(own.rows), OWN_LEVEL))
        for _ in range(OWN_ROUNDS):
            far = float(np.sum((own.wide(self.unknowns.size) @ fit.beta - own.target) ** 2))
            if far <= farthest:
                break
            stiff *= OWN_STEP * float(np.sqrt(far / farthest))
            held = replace(own, rows=stiff * own.rows, target=stiff * own.target)
            problem = replace(self.problem, prior=held)
            fit = seen(solved(self.train, self.matrix(0), problem, self.fit.sigma))
        return fit

    def relook(self) -> None:
        """Loads have changed: columns that depend on the model are made again.

        Loads are those of the coefficients that most samples agree on; a model that brings its
        own knowledge is not bent by a few samples anyway.
        """
        if not self.frozen:
            model = replace(self.with_coefficients(agreed(self.fit)), loads=None)
            self.loads, self.loads_apart = model.h, False
        else:
            model = self.model
        self._look_through(model)

    def look_at(self, loads: Array) -> None:
        """Columns are made anew with these loads; the caller refits."""
        self.loads, self.loads_apart = loads, True
        self._look_through(replace(self.with_coefficients(self.fit.beta), h=loads, loads=None))

    def look_through(self, beta: Array) -> None:
        """Columns are made anew with the loads of these coefficients; the caller refits."""
        self.loads, self.loads_apart = self.unknowns.rigid(beta), False
        self._look_through(replace(self.with_coefficients(beta), loads=None))

    def _look_through(self, model: TorqueModel) -> None:
        self.train, self.held = self.train.through(model), self.held.through(model)
        for index, term in enumerate(self.terms):
            if term.effect.uses_model:
                self.blocks[index] = self._columns(term)

    def matrix(self, side: int) -> PerJoint:
        """All columns of one side (0 training, 1 held out), joint -> (m_j, p)."""
        rigid, own = self.rigid[side], [columns[side] for columns in self.blocks]
        parts = [
            (slice(len(self.model.h)), rigid),
            *zip(self.unknowns.places, own, strict=True),
        ]
        return assembled(parts, self.unknowns.size, [len(rigid[j]) for j in range(len(rigid))])

    def held_residual(self, fit: LeastSquares | None = None) -> PerJoint:
        """joint -> (m_j,) N·m left over on the held-out side."""
        predicted = predict(self.held_matrix, (fit or self.fit).beta)
        return {j: self.held.tau[j] - predicted[j] for j in predicted}

    def rms_of(self, beta: Array) -> Array:
        """(n,) N·m that other values of the coefficients leave on the training side."""
        torque = predict(self.matrix(0), beta)
        left = [self.train.tau[j] - torque[j] for j in range(self.train.n)]
        return np.array([rms(r) for r in left])

    def train_residual(self) -> PerJoint:
        """joint -> (m_j,) N·m left over on the training side."""
        return {j: r * self.fit.sigma[j] for j, r in self.fit.residual.items()}

    def moving_rms(self) -> Array:
        """(n,) N·m on the held-out side, what is near reversals included, but not the standing in
        them: what a fit has not looked at must not become worse either."""
        squares, counts = np.zeros(self.held.n), np.zeros(self.held.n)
        for run in self.held.runs:
            error = run.driven - run.filtered(self.model.sensed(seen_by(self.model, run)))
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
            loads=self.loads if self.drawn_by_loads or self.loads_apart else None,
        )

    def _columns(self, term: Term) -> tuple[PerJoint, PerJoint]:
        return (
            self.train.columns_of_term(term),
            self.held.columns_of_term(term),
        )


def _same_samples(one: Side, other: Side) -> bool:
    """Does as much count of every one?"""
    runs = zip(one.runs, other.runs, strict=True)
    return all(a is b or np.array_equal(a.left, b.left) for a, b in runs)


def bodies_of(model: TorqueModel) -> Knowledge | None:
    """That the bodies are the model's possible ones, give or take more than anybody doubts: along
    what the data hardly show, they would run off to what no arm has. None where it has none."""
    if model.standard is None:
        return None
    return widely(model.standard, model.robot, model.base)


def own_uncertainty(model: TorqueModel, firmness: float = 1.0) -> Knowledge:
    """The model's coefficients as prior knowledge with their own covariance, their standard errors
    taken to be ``firmness`` times smaller.

    Directions that its data never showed have no variance to speak of in the covariance (they
    were truncated) and stay where they are.
    """
    mean = vector_of(model.h, model.terms)
    scale = np.sqrt(np.maximum(np.diag(model.covariance), 1e-300))
    scale = np.maximum(scale, 1e-9 * max(float(np.max(scale)), 1e-9))
    values, vectors = np.linalg.eigh(model.covariance / np.outer(scale, scale))
    values = np.maximum(values, 1e-8 * float(values[-1]))
    return Knowledge.about(mean, firmness * (vectors / np.sqrt(values)).T / scale)
