"""Positions that stand still in the file while the joint moved: old values, sent again.

What a frozen sensor or a repeated message leaves is a run of equal samples and, behind it, one
step that makes up for it, amid samples that all move on. A joint that stops has nothing to make up
for; one that sticks and slips has no neighbours that move on; a coarse encoder dwells for less than
one of its levels.
"""

from __future__ import annotations

from collections.abc import Iterator
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import CheckFinding, joint_label, percent
from pa10d.measurement.recording import Recording
from pa10d.measurement.spans import spans

Array = NDArray[np.float64]
Runs = list[tuple[int, int]]  # index of the sample that is repeated, how often

BESIDE = 5  # steps on either side that tell the speed
BEHIND = 2  # steps that make up for it: stamps off the clock divide one between two
MISTAKEN = 1e-3  # chance of one false word in a recording without any such run
MATERIAL = 0.01  # of the samples: fewer wrong ones make a fit poorer, not wrong


def check_held(recording: Recording, names: tuple[str, ...] | None) -> Iterator[CheckFinding]:
    """One finding for the joints that hold at the same samples."""
    alike: dict[tuple[tuple[int, int], ...], list[int]] = {}
    for j in range(recording.joints):
        runs = held_runs(recording.q[:, j])
        if runs:
            alike.setdefault(tuple(runs), []).append(j)
    for where, joints in alike.items():
        yield _finding(recording, where, joints, names)


def _finding(
    recording: Recording,
    runs: tuple[tuple[int, int], ...],
    joints: list[int],
    names: tuple[str, ...] | None,
) -> CheckFinding:
    first, longest = max(runs, key=lambda run: run[1])
    held = sum(count for _, count in runs)
    share = held / len(recording.t)
    times = f"{len(runs)} times, the longest for" if len(runs) > 1 else "for"
    samples = "sample" if longest == 1 else "samples"
    return CheckFinding(
        "error" if share > MATERIAL else "warning",
        "held",
        f"{', '.join(joint_label(j, names) for j in joints)}: q repeats an old value {times} "
        f"{longest} {samples} ({longest / recording.rate:.2g} s) at {recording.t[first]:.3f} s "
        f"and jumps behind it by what it moved meanwhile; {percent(share)} of the samples in all",
        "look for a sensor that freezes, or messages that are lost and sent again; leave these "
        "stretches out of a fit",
        joints[0] + 1 if len(joints) == 1 else None,
    )


def held_runs(q: Array) -> Runs:
    """q (N,) at equal steps. Where its value is surely an old one.

    Tested against a sensor that is alive: its reading stays while the joint moves less than one
    level and what the noise hides, at a chance of MISTAKEN for all samples together.
    """
    steps = np.diff(q)
    first, count = _zeros(steps)
    behind = first + count  # the first step that moves again
    inside = (first >= BESIDE) & (behind + BEHIND + BESIDE <= len(steps))
    first, count, behind = first[inside], count[inside], behind[inside]
    if not len(first):
        return []
    level = float(np.abs(steps[steps != 0]).min())
    caught_up = q[behind + BEHIND] - q[behind]
    likely = np.abs(caught_up) > level  # the few that are worth their neighbours
    first, count, behind = first[likely], count[likely], behind[likely]
    reach = np.arange(BESIDE)
    beside = np.stack([
        steps[first[:, None] - 1 - reach],
        steps[behind[:, None] + BEHIND + reach],
    ])  # fmt: skip
    beside *= np.sign(caught_up[likely])[:, None]
    usual = np.median(beside, axis=2)  # (2, K): a joint may speed up or slow down meanwhile
    slow = usual.min(axis=0)
    moves_on = (beside > usual[:, :, None] / 2).all(axis=(0, 2)) & (slow > 0)
    noise = 1.4826 * float(np.median(np.abs(np.diff(steps))))  # σ of a step, or more
    sure = -NormalDist().inv_cdf(MISTAKEN / (2 * len(q)))
    missed = count * slow > level + sure * max(noise, level)
    made_up = np.abs(caught_up[likely]) > (count / 2 + BEHIND) * usual.mean(axis=0)
    found = moves_on & missed & made_up
    return [(int(k), int(n)) for k, n in zip(first[found], count[found], strict=True)]


def _zeros(steps: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where steps are none at all: first of each run, and how many."""
    first, end = spans(steps == 0).T
    return first, end - first
