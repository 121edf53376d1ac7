"""Which joints count the other way round; where none does, whose torque is in another unit.

The arm's geometry alone tells a sign: a recording with a joint turned round is fitted worse than
the same recording with that joint turned back. Which of two joints is turned round, where either
would do, the URDF's bodies tell.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import CheckFinding, Mend, joint_label
from pa10d.checks.scales import check_scales
from pa10d.checks.textbook_view import (
    CUTOFF,
    FEWEST,
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
Way = tuple[int, tuple[int, int]]
"""A joint, and the signs of its q and its tau."""
TURNED = {(-1, 1): ("q", "dq"), (1, -1): ("tau",), (-1, -1): ("q", "dq", "tau")}


def check_geometry(recording: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """Joints that are turned round, and torques that weigh another arm."""
    part = middle_of(recording)
    view = TextbookView.of(part, robot, base_parameters(robot).kept)
    turned = {} if view is None else dict(_turned(part, robot, view))
    for j, (signs, share) in sorted(turned.items()):
        label = joint_label(j, robot.joint_names)
        what = " and ".join(name for name in TURNED[signs] if name != "dq")
        have = [name for name in TURNED[signs] if name != "dq" or recording.dq is not None]
        turns = tuple(Mend(f"{name}{j + 1}", "-1") for name in have)
        yield CheckFinding(
            "warning",
            "turned",
            f"{label}: {what} counts the other way than the URDF: turned round, the textbook model "
            f"leaves {share:.0%} of the error",
            f"--map {' '.join(turn.option for turn in turns)}",
            j + 1,
            turns,
        )
    if not turned:
        yield from check_scales(part, robot, view)


def _turned(
    part: Recording, robot: Robot, view: TextbookView
) -> Iterator[tuple[int, tuple[tuple[int, int], float]]]:
    """The joint whose turning round helps most is turned, if it surely helps; then the others are
    asked again."""
    kept = base_parameters(robot).kept
    left = view.left()
    if len(left) < FEWEST:
        return
    asked = set(range(robot.n))
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
        yield j, (signs, float(found[way].sum() / max(left.sum(), 1e-300)))
        part = _with_signs(part, j, signs)
        view, left = TextbookView.of(part, robot, kept, view.scale) or view, found[way]
        asked.remove(j)


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
