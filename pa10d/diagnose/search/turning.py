"""The shape of friction where its joint turns round, of which no fit sees much.

A fit clear of reversals may follow the foot of a law to the last digit and say little of its peak,
which then lies anywhere and makes reversals worse. They tell something of the shape all the same,
as far as their own error, which is larger, lets them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from pa10d.diagnose.regression.least_squares import LeastSquares
from pa10d.diagnose.regression.partial import PartialFit
from pa10d.diagnose.regression.shapes import free_shapes
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.effects import Shape
from pa10d.model import Term
from pa10d.regression.per_joint import assembled, rms


def told_by_reversals(term: Term) -> bool:
    """Is it friction of one joint with a shape of its own, more than how sharp its corner is?"""
    free = free_shapes(term.effect, term.shape)
    return term.effect.carried and any(not s.smoothing for s in free)


def drop_at_reversals(
    state: SearchState, rest: LeastSquares, term: Term
) -> Callable[[Shape, PartialFit], float]:
    """What a shape of the term, beside ``rest``, takes from its joint's squared error where that
    turns round on the fit side, in units of the larger error that is left there."""
    j, near = term.joints[0], _turning(state.train)
    columns = [near.columns_of_term(one) for one in state.terms]
    parts = [
        (slice(len(state.model.h)), near.rigid(state.model.base.kept)),
        *zip(state.unknowns.places, columns, strict=True),
    ]
    matrix = assembled(parts, state.unknowns.size, [len(tau) for tau in near.tau])[j]
    left, taken_in = near.tau[j] - matrix @ rest.beta, matrix @ rest.to_beta
    unit = max(float(rest.sigma[j]), rms(left)) ** 2 if len(left) else 1.0

    def drop(shape: Shape, fitted: PartialFit) -> float:
        (own,) = near.columns(term.effect, term.joints, [shape]).values()
        change = own @ fitted.theta - taken_in @ (fitted.seen @ fitted.theta)
        return float(2 * change @ left - change @ change) / unit

    return drop


def _turning(side: Side) -> Side:
    """Its samples near reversals, but for the standing in them."""
    runs = tuple(replace(run, keep=run.moving & ~run.keep) for run in side.runs)
    return replace(side, runs=runs, kept_by_evidence={})
