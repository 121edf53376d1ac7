"""What is left of every joint's error after all that was found, in one line each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pa10d.compare.above_band import lines_above_band
from pa10d.compare.knocks import knocks
from pa10d.compare.orders import order_spectrum
from pa10d.compare.places import places
from pa10d.diagnose.search.begun import Begun
from pa10d.diagnose.search.finished import Finished
from pa10d.diagnose.search.frozen import AsItStood
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.unknown.among_knocks import among_knocks
from pa10d.diagnose.unknown.at_most import most_noise
from pa10d.diagnose.unknown.beyond import beyond
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.diagnose.unknown.left_over import LeftOver, unsaid
from pa10d.diagnose.unknown.of_joint import KnownBesides
from pa10d.diagnose.unknown.remaining import Remaining, remaining


@dataclass(frozen=True)
class Rest:
    """lines: of every joint; above_band: by joint (0-based) and in words, what the low-pass takes
    away; knocked: joints whose error lies in a few moments."""

    lines: tuple[Remaining, ...]
    above_band: dict[int, str]
    knocked: tuple[int, ...]


def rest_of(
    begun: Begun, search: Search, end: Finished, over: LeftOver, stood: AsItStood, searched: bool
) -> Rest:
    """over: what of it is structure; stood: of a frozen model; searched: more than one suspicion
    was looked for."""
    state, robot = search.state, begun.model.robot
    left, seen = end.left, end.seen
    said_of = [u for u in over.unexplained if not isinstance(u, Unnamed)]
    open_ = unsaid(left, said_of) if searched else []
    silent = [j for j in open_ if np.isfinite(left.ratio[j])]
    floor = left.floor.values
    stand_out = places(seen, robot, floor, joints=silent, clear=True) if open_ else ()
    turning = [j for j in open_ if not robot.prismatic[j]]
    orders = [order_spectrum(seen, j) if j in turning else None for j in range(robot.n)]
    knocked = {j: found for j in open_ if (found := knocks(seen, j)) is not None}
    above = lines_above_band(orders, left.cutoff, left.rms)
    besides = KnownBesides(
        found=state.terms[begun.given :],
        searched=searched,
        slight=over.slight,
        doubt=over.doubt,
        beyond=beyond(state),
        gains={**search.rival_gains, **over.gains},
        stand_out=stand_out,
        silent=state.held.silent,
        undetermined=over.undetermined,
        faster=above,
        beside=over.beside,
        knocked={j: found.words for j, found in knocked.items()},
        outdone=search.outdone,
        dead_bands=search.dead_bands,
        knocks=among_knocks(state),
        most_noise=most_noise(state),
        usual=state.usual,
        lacked=begun.model.noise,
        as_given=state.as_given,
        moved=np.flatnonzero(stood.far).tolist(),
        alone=stood.alone,
    )
    units = [robot.torque_unit(j) for j in range(robot.n)]
    lines = remaining(left, end.again, over.unexplained, units, besides)
    return Rest(lines, above, tuple(knocked))
