"""Channels that are coarser than their samples look: renewed only now and then, or rounded."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import CheckFinding, joint_label
from pa10d.dynamics.robot import Robot
from pa10d.measurement.recording import Recording

Array = NDArray[np.float64]

SELDOM = 100  # samples: what is renewed less often is no channel of a motion
FEWEST = 20  # renewals that tell a rhythm
KEPT = 0.95  # share of them that must keep it: stamps and messages are lost now and then
BITS = 10  # per turn: no encoder of an arm is coarser, a number that was rounded is
LEVELS = 1000  # across the range of a motion: finer is no matter
WHOLE = 0.1  # of a level by which a value may be off a whole number of them


def check_resolution(recording: Recording, robot: Robot | None) -> Iterator[CheckFinding]:
    """Per channel, the joints that are alike in one line."""
    names = None if robot is None else robot.joint_names
    for kind, block in (("q", recording.q), ("tau", recording.tau)):
        alike: dict[int, list[int]] = {}
        for j in range(recording.joints):
            if every := renewed_every(block[:, j]):
                alike.setdefault(every, []).append(j)
        for every, joints in alike.items():
            yield CheckFinding(
                "warning",
                "seldom",
                f"{', '.join(joint_label(j, names) for j in joints)}: {kind} is new at every "
                f"{every}th sample only ({recording.rate / every:.4g} Hz), and the same between",
                "log it as fast as the rest, or keep every such sample and leave the others out: "
                "it comes late by half of that on the average",
            )
    turning = range(recording.joints) if robot is None else np.flatnonzero(~robot.prismatic)
    rounded = {int(j): level_of(recording.q[:, j]) for j in turning}
    worst = {j: level for j, level in rounded.items() if level > 2 * np.pi / 2**BITS}
    if worst:
        j = max(worst, key=lambda one: worst[one])
        yield CheckFinding(
            "warning",
            "rounded",
            f"{', '.join(joint_label(j, names) for j in worst)}: q comes in steps of "
            f"{worst[j]:.3g} rad, fewer than {2**BITS} a turn: rounded by who wrote it?",
            "log more digits: speeds and accelerations come from differences of q",
        )


def renewed_every(values: Array) -> int | None:
    """(N,) After how many samples a channel has a new value, where that is more than one and by
    more than its finest step; None where every sample is its own, or nothing keeps a rhythm."""
    steps = np.diff(values)
    at = np.flatnonzero(steps)
    if len(at) < FEWEST or 2 * len(at) > len(steps) + 1:
        return None
    apart = np.diff(at)
    sizes = np.abs(steps[at])
    if np.median(sizes) < 1.5 * sizes.min():
        return None  # a sensor that goes from one level to the next
    every = int(np.median(apart))
    if not 2 <= every <= SELDOM:
        return None
    kept = float(np.mean(apart % every == 0))
    return every if kept >= KEPT else None


def level_of(q: Array) -> float:
    """rad between the values that a channel (N,) takes, where they are whole numbers of one step;
    0 where they are not."""
    taken = np.unique(q)
    if len(taken) < FEWEST:
        return 0.0
    level = float(np.diff(taken).min())
    if not level > 0 or np.ptp(taken) / level > LEVELS:
        return 0.0
    level = float(np.median(np.diff(taken)[np.diff(taken) < 1.5 * level]))
    off = (taken - taken[0]) / level
    return level if float(np.abs(off - np.rint(off)).max()) < WHOLE else 0.0
