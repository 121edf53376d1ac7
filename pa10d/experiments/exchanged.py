"""Is a joint's drive another joint's? By what the joints weigh in a first motion.

Node ids that are mixed up between drives with the same counts and gears look right joint by joint:
each servo has its own encoder. But what turns is another joint than the one that is asked for, and
weight goes with the pose that the arm really has. Compared as mounts are (``mounting``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pa10d.control.joint_figures import ROUGH, JointFigures
from pa10d.dynamics import Robot
from pa10d.experiments.mounting import SURE, TIMES, left_by
from pa10d.profile import Profile

Array = NDArray[np.float64]


def alike(profile: Profile) -> list[tuple[int, int]]:
    """Pairs of joints (0-based) whose drives count alike, so that nothing else tells them apart."""
    drives = profile.drives or []
    scales = [(one.counts_per_rev, one.gear_ratio) for one in drives]
    return [(i, j) for i, j in combinations(range(len(scales)), 2) if scales[i] == scales[j]]


def exchanged_drives(
    robot: Robot,
    figures: JointFigures,
    seen: Sequence[tuple[Array, Array, float]],
    pairs: Sequence[tuple[int, int]],
) -> str | None:
    """In a sentence; None where each drive may be its joint's. seen: see ``felt_bodies``."""
    pairs = [(i, j) for i, j in pairs if robot.prismatic[i] == robot.prismatic[j]]
    if not pairs or not robot.gravity.any():
        return None
    told = left_by(robot, figures, seen)
    found = {pair: _exchanged(robot, figures, seen, pair) for pair in pairs}
    best = min(found, key=lambda pair: found[pair])
    if told - found[best] < SURE**2 or told < TIMES**2 * found[best]:
        return None
    i, j = best[0] + 1, best[1] + 1
    return (
        f"by what its joints weigh the drives of joints {i} and {j} are exchanged: what is called "
        f"joint {i} turns joint {j}, and the other way round; with that the URDF's bodies, each up "
        f"to {ROUGH:g} times heavier or lighter, leave {np.sqrt(told / found[best]):.2g} times "
        "less of what was measured; turn each by hand, exchange their node ids in the profile, and "
        "run first_motion again"
    )


def _exchanged(
    robot: Robot,
    figures: JointFigures,
    seen: Sequence[tuple[Array, Array, float]],
    pair: tuple[int, int],
) -> float:
    order = np.arange(robot.n)
    order[list(pair)] = order[list(reversed(pair))]
    own = figures.but(
        rotor=figures.rotor[order], coulomb=figures.coulomb[order], viscous=figures.viscous[order]
    )
    # what a drive's torque is unsure by goes along with it: a weak motor's seems small beside a
    # strong one's, and explained by anything
    drives = replace(robot, effort=robot.effort[order])
    return left_by(drives, own, [(q[:, order], torque[:, order], rate) for q, torque, rate in seen])
