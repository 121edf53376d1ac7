"""Where a model fails: all significant regions and curves, ranked, each said once."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import joint_words, listed, rounded, times
from pa10d.compare.curves import Curve
from pa10d.compare.knocks import knocks
from pa10d.compare.phrases import sentence
from pa10d.compare.quantities import Values, quantities
from pa10d.compare.regions import Region
from pa10d.compare.samples import joint_samples
from pa10d.compare.search import PlaceSearch
from pa10d.dynamics import Robot
from pa10d.judgement import MATERIAL, RunResidual, Scores, hidden_in
from pa10d.judgement.scores import moving

Array = NDArray[np.float64]

LEVEL = 0.01  # chance that noise alone makes any place, over all joints and quantities
CLEAR_LEVEL = 0.1  # the same for joints whose error is clearly more than noise: there it is
OF_JUDGED = "its squared error"
OVER_ALL = "its squared error with reversals"
CLEAR = 1.5  # times the noise floor, and only its place may be an accident


@dataclass(frozen=True)
class Place:
    """joint: 0-based; p_value: corrected for everything that was looked at."""

    joint: int
    what: Region | Curve
    sentence: str
    p_value: float

    @property
    def variable(self) -> str:
        """The quantity's name, ``constant`` for a constant error."""
        return self.what.quantity.name if self.what.quantity else "constant"


def failing(
    judged: Scores,
    floor: Array,
    robot: Robot,
    found: Sequence[Place],
    runs: Sequence[RunResidual],
    fitted: Array,
) -> list[str]:
    """One sentence for every joint that keeps materially more than its noise (n,) N·m though no
    place of its error stands out, or all of it lies in a few moments of the runs, one for all whose
    torque is known nowhere, and one for all whose noise is not known; fitted: (n,) N·m that the
    model leaves on the runs that it was fitted to, all their noise included."""
    hidden = hidden_in(runs)
    told, said = {place.joint for place in found} | {*hidden}, []
    if hidden:
        one = len(hidden) == 1
        said.append(
            f"The torque of {joint_words(hidden)} is known nowhere in these runs: "
            f"{'its channel' if one else 'each channel'} mostly shows one value or a limit. What "
            "is left there says nothing of the model."
        )
    for j, (rms, noise) in enumerate(zip(judged.rms, floor, strict=True)):
        known = noise > 0
        if j in told or (known and rms <= MATERIAL * noise):
            continue
        size = f"Joint {j + 1} keeps {rounded(rms, 3)} {robot.torque_unit(j)}"
        if (knocked := knocks(runs, j)) is not None:
            told.add(j)
            said.append(f"{size}; {knocked.words}.")
        elif known:
            said.append(
                f"{size}, {times(rms / noise)} its noise floor, and no region stands out: the "
                "error is spread over all of its motion."
            )
    blind = [j for j in range(robot.n) if j not in told and not np.isfinite(floor[j])]
    more = [j for j in blind if judged.rms[j] > MATERIAL * fitted[j]]
    if more:
        ratios = [f"{judged.rms[j] / fitted[j]:.2g}" for j in more]
        keeps, whose = ("which keeps", "its") if len(more) == 1 else ("which keep", "their")
        said.append(
            f"No region stands out on {joint_words(more)}, {keeps} {listed(ratios)} times what the "
            f"model leaves on the runs that it was fitted to: {whose} noise is not known, but was "
            "hardly more than that there. What is more those runs do not show, or it came since."
        )
    blind = [j for j in blind if j not in more]
    if blind:
        said.append(
            f"No region stands out on {joint_words(blind)}, and the noise there is not known from "
            "these runs: how much of the error is the model's nobody can say. Record one motion "
            "twice; what differs is noise."
        )
    return said


def places(
    runs: list[RunResidual],
    robot: Robot,
    floor: Array | None = None,
    level: float = LEVEL,
    judged: Scores | None = None,
    joints: Collection[int] | None = None,
    clear: bool = False,
) -> list[Place]:
    """Ranked: what carries most squared error beyond its share first. floor: (n,) N·m noise;
    judged: joints that by this judgement keep no more than noise fail nowhere; joints: of these
    alone, as if all had been looked at; clear: of reversals, as the size of errors is judged."""
    found: list[Place] = []
    of_run = {run: Values(run) for run in runs}
    warm = any(run.seen.temperature is not None for run in runs)
    limit = None if floor is None else MATERIAL * floor
    kinds = 3  # constants, curves and regions are each looked for
    for joint in range(robot.n) if joints is None else joints:
        if limit is not None and judged is not None and judged.rms[joint] <= limit[joint]:
            continue
        samples = joint_samples(runs, joint, quantities(robot, joint, warm), of_run, clear)
        rms = float(np.sqrt(np.mean(samples.error**2)))
        large = floor is not None and rms > CLEAR * floor[joint]
        search = PlaceSearch(
            samples, (CLEAR_LEVEL if large else level) / robot.n / kinds, seed=joint
        )
        unit, whose = robot.torque_unit(joint), _whose(rms, runs, joint)
        found += [
            Place(joint, what, sentence(joint, what, unit, whose), min(1.0, p * robot.n * kinds))
            for what, p in search.run()
        ]
    return sorted(found, key=lambda place: -place.what.excess)


def _whose(rms: float, runs: list[RunResidual], joint: int) -> str:
    """Which squared error it is, where much of it lies at reversals, by which no size is judged."""
    used = moving(runs, joint)
    judged = np.concatenate([run.error[run.judged[:, joint], joint] for run in used])
    return OVER_ALL if rms > MATERIAL * float(np.sqrt(np.mean(judged**2))) else OF_JUDGED
