"""Columns that were dealt to other joints: exchanged, in reverse, or shifted by one.

The arm's geometry tells it as it tells a sign (``pa10d.checks.textbook_view``): the textbook model,
all its masses free, explains a recording best with every joint in its place.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import CheckFinding, Mend
from pa10d.checks.textbook_view import TextbookView, likelihood, middle_of, surely_better
from pa10d.dynamics import Robot, base_parameters
from pa10d.measurement.recording import Recording

Array = NDArray[np.float64]

FAST = 80.0  # Hz: what geometry is asked of lies below 5 Hz
LONGEST = 15.0  # s of the recording that are used
MOVED = (("q", "tau"), ("q",), ("tau",))  # what may have been dealt otherwise


def check_order(recording: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """One finding at most: the order that explains most, if it surely explains more."""
    if robot.n < 2:
        return
    found = _better(_thinned(middle_of(recording, LONGEST)), robot)
    if found is None:
        return
    order, moved, share = found
    kinds = [*moved, *(["dq"] if "q" in moved and recording.dq is not None else [])]
    mends = tuple(
        Mend(f"{kind}{j + 1}", "", source=f"{kind}{k + 1}")
        for kind in kinds
        for j, k in enumerate(order)
        if j != k
    )
    yield CheckFinding(
        "warning",
        "order",
        f"{' and '.join(moved)} of joints {_words(order)} seem dealt to other joints: in the order "
        f"{', '.join(str(k + 1) for k in order)} the textbook model leaves {share:.1%} of the "
        "error",
        f"--map {' '.join(mend.option for mend in mends)}",
        mends=mends,
    )


def _better(part: Recording, robot: Robot) -> tuple[tuple[int, ...], tuple[str, ...], float] | None:
    """The order, of what, that explains most, if that is surely more; and which share of the error
    it leaves."""
    kept = base_parameters(robot).kept
    view = TextbookView.of(part, robot, kept)
    if view is None:
        return None
    left = view.left()
    found: dict[tuple[tuple[int, ...], tuple[str, ...]], Array] = {}
    for order in _orders(robot.n):
        places = list(order)
        dealt = replace(part, q=part.q[:, places])
        other = TextbookView.of(dealt, robot, kept, view.scale)
        for moved in MOVED:
            seen = other if "q" in moved else view
            if seen is None:
                continue
            new = (seen.dealt(places) if "tau" in moved else seen).left()
            found[order, moved] = new[:, np.argsort(order)] if "tau" in moved else new
    whole = {way: new for way, new in found.items() if len(new) == len(left)}
    if not whole:
        return None
    best = max(whole, key=lambda way: likelihood(whole[way], left))
    (order, what), new = best, whole[best]
    if not surely_better(new, left, np.arange(robot.n) != list(order)):
        return None
    return order, what, float(new.sum() / left.sum())


def _orders(n: int) -> list[tuple[int, ...]]:
    """Two exchanged, all in reverse, all shifted by one: which column each joint is read from."""
    own = list(range(n))
    out = [tuple(own[1:] + own[:1]), tuple(own[-1:] + own[:-1]), tuple(own[::-1])]
    for i, j in combinations(own, 2):
        order = own.copy()
        order[i], order[j] = j, i
        out.append(tuple(order))
    return list(dict.fromkeys(out))


def _thinned(part: Recording) -> Recording:
    """Fewer samples: dozens of orders are asked."""
    step = max(1, int(part.rate / FAST))
    thin = slice(None, None, step)
    return Recording(part.name, part.t[thin], part.q[thin], part.tau[thin], excluded=part.excluded)


def _words(order: tuple[int, ...]) -> str:
    places = [str(j + 1) for j, k in enumerate(order) if j != k]
    return f"{', '.join(places[:-1])} and {places[-1]}"
