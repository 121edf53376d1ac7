"""The fit itself, with what is known besides and the possible bodies nearest to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from pa10d.identify.blocks import Pieces
from pa10d.identify.feasibility import FeasibleModel, find_feasible
from pa10d.identify.fit import Fit, beside_bodies, trust, weighted_fit, wide_bodies
from pa10d.identify.prior import Prior
from pa10d.identify.robust import robust_fit
from pa10d.identify.seen import SeenRuns
from pa10d.regression.problem import LinearProblem


@dataclass(frozen=True)
class Solved:
    """rank: of what the data alone determine, unless something is known besides; contradicted: of
    that, what the data speak against, in words."""

    fit: Fit
    rank: int
    feasible: FeasibleModel
    contradicted: tuple[str, ...]


def solved(
    pieces: Pieces,
    seen: SeenRuns,
    known: Prior | None,
    robust: bool,
    say: Callable[[float, str], None],
) -> Solved:
    """known: what somebody knows of the parameters; robust: outliers count little."""
    say(0.6, "least squares")
    layout, smoothing = seen.layout, seen.smoothing
    fitted = robust_fit if robust else weighted_fit
    bodies = wide_bodies(layout) if known is None else None
    sigma, beside_them = trust(pieces, layout, bodies)
    problem = LinearProblem(layout, sigma=sigma)
    pieces.without_stands()
    fit = fitted(pieces, problem, smoothing)
    rank = fit.solution.rank
    if bodies is not None:
        again = replace(problem, sigma=beside_them)
        fit = beside_bodies(
            fit, bodies, lambda b: fitted(pieces, replace(again, bodies=b), smoothing)
        )
    beside, contradicted = None, tuple[str, ...]()
    if known is not None:
        say(0.75, "least squares with what is known")
        beside, contradicted = known.beside(fit), tuple(known.contradicted(fit))
        fit = fitted(pieces, replace(problem, prior=beside.whole()), smoothing)
        rank = fit.solution.rank
    say(0.9, "feasible parameters")
    return Solved(fit, int(rank), find_feasible(fit, layout, beside), contradicted)
