"""Which joints count the other way round; where none does, whose torque is in another unit.

Friction tells a sign: it would drive a joint that is turned round. So does the arm's geometry: a
recording with a joint turned round is fitted worse than the same with that joint turned back.
Which of two joints is turned round, where either would do, the URDF's bodies tell.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import CheckFinding, Mend, joint_label
from pa10d.checks.scales import check_scales
from pa10d.checks.textbook_view import (
    BETTER,
    CUTOFF,
    FEWEST,
    SURE,
    TextbookView,
    ahead,
    likelihood,
    middle_of,
    surely_better,
)
from pa10d.dynamics import Robot, base_parameters, inverse_dynamics
from pa10d.measurement.recording import Recording
from pa10d.regression.equation import prepare

Array = NDArray[np.float64]

ALIKE = 1e-2  # of the log-likelihood per sample, by which two ways to turn joints are the same one
MOST_WAYS = 3  # joints, for each of which both q and tau are tried
Way = tuple[int, tuple[int, int]]
"""A joint, and the signs of its q and its tau."""
TURNED = {(-1, 1): ("q", "dq"), (1, -1): ("tau",), (-1, -1): ("q", "dq", "tau")}


def check_geometry(recording: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """Joints that are turned round, and torques that weigh another arm."""
    part = middle_of(recording)
    view = TextbookView.of(part, robot, base_parameters(robot).kept)
    turned = {} if view is None else dict(_turned(part, robot, view))
    for j, (signs, why) in sorted(turned.items()):
        label = joint_label(j, robot.joint_names)
        what = " and ".join(name for name in TURNED[signs] if name != "dq")
        have = [name for name in TURNED[signs] if name != "dq" or recording.dq is not None]
        turns = tuple(Mend(f"{name}{j + 1}", "-1") for name in have)
        yield CheckFinding(
            "warning",
            "turned",
            f"{label}: {what} counts the other way than the URDF: {why}",
            f"--map {' '.join(turn.option for turn in turns)}",
            j + 1,
            turns,
        )
    if not turned:
        yield from check_scales(part, robot, view)


def _turned(
    part: Recording, robot: Robot, view: TextbookView
) -> Iterator[tuple[int, tuple[tuple[int, int], str]]]:
    """Joints with their signs and what tells so: first those that friction would drive, all
    together; then the one whose turning round helps most, if it surely helps, and again."""
    kept = base_parameters(robot).kept
    if len(view.left()) < FEWEST:
        return
    asked = set(range(robot.n))
    for j, signs, why in _driven(part, robot, view):
        yield j, (signs, why)
        part = _with_signs(part, j, signs)
        asked.remove(j)
    if len(asked) < robot.n:
        view = TextbookView.of(part, robot, kept, view.scale) or view
    left = view.left()
    while asked:
        found = {}
        for j in sorted(asked):
            other = TextbookView.of(_with_signs(part, j, (-1, 1)), robot, kept, view.scale)
            for signs in TURNED:
                seen = view if signs[0] > 0 else other
                if seen is not None:
                    found[j, signs] = seen.scaled(j, signs[1]).left()
        way = _likeliest(found, left, part, robot)
        if way is None:
            return
        j, signs = way
        share = float(found[way].sum() / max(left.sum(), 1e-300))
        yield j, (signs, f"turned round, the textbook model leaves {share:.0%} of the error")
        part = _with_signs(part, j, signs)
        view, left = TextbookView.of(part, robot, kept, view.scale) or view, found[way]
        asked.remove(j)


def _driven(
    part: Recording, robot: Robot, view: TextbookView
) -> list[tuple[int, tuple[int, int], str]]:
    """Joints that friction surely would drive, and to no small part: q or tau of each is turned
    round. Which of the two, what joints do to each other tells; where it surely does not, that is
    said, too."""
    kept = base_parameters(robot).kept
    rubs = [view.rubs(j) for j in range(robot.n)]
    driven = [j for j, (errors, share) in enumerate(rubs) if errors < -SURE and share < BETTER]
    each = [(1, -1), (-1, 1)] if len(driven) <= MOST_WAYS else [(1, -1)]
    found = {}
    for ways in product(each, repeat=len(driven)) if driven else ():
        turned = part
        for j, signs in zip(driven, ways, strict=True):
            turned = _with_signs(turned, j, signs)
        seen = TextbookView.of(turned, robot, kept, view.scale)
        if seen is not None and not any(seen.drives(j) for j in driven):
            found[ways] = (turned, seen.left())
    if not found:
        return []
    left = view.left()
    most = max(likelihood(new, left) for _, new in found.values())
    same = [w for w, (_, new) in found.items() if likelihood(new, left) >= most - ALIKE]
    best = max(same, key=lambda ways: _likeness(found[ways][0], robot))
    if ahead(left, found[best][1]):
        return []
    alike = [ways for ways, (_, new) in found.items() if not ahead(found[best][1], new)]
    told = []
    for place, (j, signs) in enumerate(zip(driven, best, strict=True)):
        why = f"as it is, friction would drive the joint ({-rubs[j][0]:.0f} standard errors)"
        if any(ways[place] != signs for ways in alike):
            other = TURNED[-signs[0], -signs[1]][0]
            why += f"; turning {other} instead would do nearly as well"
        told.append((j, signs, why))
    return told


def _likeliest(
    found: Mapping[Way, Array], left: Array, part: Recording, robot: Robot
) -> Way | None:
    """The way that explains most, if that is surely more than the recording as it is; of those that
    are not surely behind it, its joint's own or sure, too, the one nearest to the URDF's bodies:
    turning one of two joints is as good as turning the other with everything mirrored or of
    negative mass. A way that explains less is never the answer, even where it alone is sure, nor is
    one by which friction would drive its joint."""
    joints = np.arange(robot.n)
    best = max(found, key=lambda way: likelihood(found[way], left), default=None)
    if best is None or not surely_better(found[best], left, joints == best[0]):
        return None
    most = likelihood(found[best], left)
    same = {way for way, new in found.items() if likelihood(new, left) >= most - ALIKE}
    alike = [
        way
        for way, new in found.items()
        if way in same
        or (
            not ahead(found[best], new)
            and (way[0] == best[0] or surely_better(new, left, joints == way[0]))
        )
    ]
    kept = base_parameters(robot).kept
    turned = {way: _with_signs(part, *way) for way in alike}
    views = {way: TextbookView.of(one, robot, kept) for way, one in turned.items()}
    braking = [way for way in alike if (v := views[way]) is not None and not v.drives(way[0])]
    if not same & {*braking}:  # what is behind it at all is no more than the next best
        return None
    return max(braking, key=lambda way: _likeness(turned[way], robot))


def _likeness(part: Recording, robot: Robot) -> float:
    """Correlation of the torques with those of the URDF's bodies, over all joints."""
    run = prepare(replace(part, dq=None), robot, min(CUTOFF, part.rate / 8))
    c = run.context
    bodies = run.lowpass(inverse_dynamics(robot, robot.parameters, c.q, c.dq, c.ddq))
    scale = np.maximum(run.tau.std(axis=0), 1e-9)
    a, b = (each * run.keep for each in (run.tau / scale, bodies / scale))
    return float((a * b).sum() / max(np.linalg.norm(a) * np.linalg.norm(b), 1e-300))


def _with_signs(part: Recording, joint: int, signs: tuple[int, int]) -> Recording:
    q, tau = part.q.copy(), part.tau.copy()
    q[:, joint] *= signs[0]
    tau[:, joint] *= signs[1]
    return replace(part, q=q, tau=tau)
