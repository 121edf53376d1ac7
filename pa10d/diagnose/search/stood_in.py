"""What is no effect at all: runs that contradict each other, lengths and axes that are not the
URDF's. Findings that only stood in for that are dropped."""

from __future__ import annotations

from dataclasses import dataclass

from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.begun import Begun
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.suspects import heard, suspects
from pa10d.diagnose.unknown.between_runs import Apart, contradiction, needless
from pa10d.diagnose.unknown.geometry import Geometry, OtherGeometry, other_geometry


@dataclass(frozen=True)
class NoEffects:
    """apart: what fitted runs contradict each other in; geometry: as far as it was looked at."""

    apart: tuple[Apart, ...]
    geometry: Geometry

    @property
    def told(self) -> list[Apart | OtherGeometry]:
        """A line for each joint concerned."""
        return [*self.apart, *self.geometry.told]


def not_asked(search: Search) -> NoEffects:
    """As where nobody looked for it."""
    return NoEffects((), Geometry((), search.state))


def no_effects(search: Search, begun: Begun) -> NoEffects:
    """After a search; its state is without what only stood in for what is found here. Lengths and
    axes are asked of a model that is fitted anew: no arm changes those."""
    apart = _between_runs(search, begun)
    if apart or search.state.frozen:
        return NoEffects(apart, Geometry((), search.state))
    return NoEffects((), _geometry(search, begun))


def _between_runs(search: Search, begun: Begun) -> tuple[Apart, ...]:
    floor = begun.error.floor.values
    may_change = heard(suspects(True, begun.model.robot.n), search.state.held)
    _go_on_with(search, needless(search.state, may_change, begun.given, floor))
    return contradiction(search.state, may_change, floor).told


def _geometry(search: Search, begun: Begun) -> Geometry:
    likewise = [(e, j) for e, j in search.suspects if e.seen_by_shared_bodies]
    floor = begun.error.floor.values
    found = other_geometry(search.state, likewise, begun.given, floor)
    _go_on_with(search, found.state)
    return found


def _go_on_with(search: Search, rest: SearchState) -> None:
    if rest is not search.state:
        search.state = rest
        search.settle()
