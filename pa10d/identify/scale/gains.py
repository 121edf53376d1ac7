"""Gains of the joints from runs without and with known weights, and what their errors are made of.

Three things keep a gain from being exact, and each is told. *Noise*, over stretches of a second,
and over recordings where these disagree. *The weight*: its mass and the place of its centre, as
well as they are stated. *Friction that goes with the load*: what is the same in both directions is
set apart; what acts more while the motor drives the load than while the load drives the motor is,
in motion, the same as a larger gain, whatever the mass: lifting takes s·(1+μ₁)·p, sinking
s·(1-μ₂)·p, two slopes for three unknowns, and every further mass gives the same two. So, where
friction with the load is seen, the gain is bounded: it lies between the sinking slope (all of it
acts while the motor drives) and the mean of both (it acts alike), each with two of its standard
errors beyond, as either end may be the truth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.identify.scale.body import Body
from pa10d.identify.scale.regression import Regression, regression
from pa10d.identify.scale.rows import (
    SEEN,
    WeighedRun,
    WeighingEquations,
    error_over_blocks,
    outside,
    parts_of,
    rows_of,
    without,
)
from pa10d.measurement.recording import Recording

Array = NDArray[np.float64]

TOLD = 0.25  # of a gain: a larger standard error cannot tell a drive from one half as strong again
RUBS = 2.0  # standard errors from which on friction with the load counts as seen
BEYOND = 2.0  # standard errors that a bound lies outside of its best value


@dataclass(frozen=True)
class Load:
    """Runs with one known weight."""

    runs: Sequence[Recording]
    body: Body


@dataclass(frozen=True)
class JointGain:
    """gain: measured torque over true torque, NaN where it is not determined; std_error: of it,
    from of_noise and of_body together; between: bounds that friction with the load leaves, with
    two standard errors beyond, None where none is seen; rubs: that friction over the load;
    disagree: the runs' own gains spread further than their errors and chance (of_noise is
    widened); spread: standard deviation of the gain from run to run where they do; asked: N·m (rms)
    of the weight; why: for a gain that is not determined."""

    gain: float
    std_error: float
    of_noise: float
    of_body: float
    between: tuple[float, float] | None = None
    rubs: float = 0.0
    disagree: bool = False
    spread: float = 0.0
    asked: float = 0.0
    why: str = ""

    @property
    def told(self) -> bool:
        """Whether it is determined."""
        return bool(np.isfinite(self.gain))


@dataclass(frozen=True)
class TorqueGains:
    """joints: one each; residuals: (M, n) N·m per run, what no gain explains; parts: the runs."""

    joints: tuple[JointGain, ...]
    parts: tuple[WeighedRun, ...]
    residuals: tuple[Array, ...]

    @property
    def gain(self) -> Array:
        """(n,), NaN where it is not determined."""
        return np.array([joint.gain for joint in self.joints])

    @property
    def std_error(self) -> Array:
        """(n,), NaN where the gain is not determined."""
        return np.array([joint.std_error for joint in self.joints])


def torque_gains(robot: Robot, empty: Sequence[Recording], loads: Sequence[Load]) -> TorqueGains:
    """Gains from runs without and with known weights; without any empty run the weights are taken
    for the whole arm."""
    parts = parts_of(robot, empty, _merged(loads))
    joints, residuals = [], [np.zeros_like(part.run.tau) for part in parts]
    for j in range(robot.n):
        rows = rows_of(parts, j)
        found, left = _joint(rows, robot.torque_unit(j))
        joints.append(found)
        for number, part in enumerate(parts):
            residuals[number][part.run.keep[:, j], j] = left[rows.runs == number]
    return TorqueGains(tuple(joints), tuple(parts), tuple(residuals))


def _merged(loads: Sequence[Load]) -> list[tuple[Body, list[Recording]]]:
    """Runs by their weight: one that was hung twice is off alike both times."""
    runs: dict[Body, list[Recording]] = {}
    for load in loads:
        runs.setdefault(load.body, []).extend(load.runs)
    return list(runs.items())


def _joint(rows: WeighingEquations, unit: str) -> tuple[JointGain, Array]:
    loaded = rows.asked[rows.load >= 0]
    asked = float(np.sqrt(np.mean(loaded**2))) if len(loaded) else 0.0
    seen, left = regression(rows)
    if seen is None:
        return _untold(asked, "the weight asks nothing of it"), left
    gain, error = seen.gain, seen.std_error
    if not error < TOLD * abs(gain):
        little = f"the weight asks {asked:.2g} {unit} of it: too little to tell"
        why = "recordings disagree" if seen.disagree else little
        return _untold(asked, f"{why} ({gain:.2g} ± {error:.2g})", seen), left
    between, rubs = _bounds(rows, gain, error)
    of = seen.of_noise, seen.of_body
    return JointGain(gain, error, *of, between, rubs, seen.disagree, seen.spread, asked), left


def _untold(asked: float, why: str, seen: Regression | None = None) -> JointGain:
    nothing = (np.nan, np.nan, np.nan, np.nan)
    if seen is None:
        return JointGain(*nothing, asked=asked, why=why)
    return JointGain(*nothing, disagree=seen.disagree, spread=seen.spread, asked=asked, why=why)


def _bounds(
    rows: WeighingEquations, gain: float, error: float
) -> tuple[tuple[float, float] | None, float]:
    """Bounds of the gain with what their errors leave open beyond, where they leave more open than
    the gain's error, and friction with the load over the load."""
    basis = outside(rows.others)
    x = without(np.column_stack([rows.asked, rows.rubbing]), basis)
    alone = without(rows.rubbing, outside(np.column_stack([rows.asked, rows.others])))
    if float(alone @ alone) <= SEEN * float(rows.rubbing @ rows.rubbing):
        return None, 0.0
    inverse = np.linalg.pinv(x)
    both = float(inverse[1] @ rows.torque)
    left = without(rows.torque, basis) - x @ (inverse @ rows.torque)

    def noise(row: Array) -> float:
        return error_over_blocks(row * left, rows.blocks)

    if both <= max(RUBS * noise(inverse[1]), error):
        return None, 0.0
    more = max(error**2 - noise(inverse[0]) ** 2, 0.0)  # weights, disagreement: as of the gain
    below = float(np.sqrt(noise(inverse[0] - inverse[1]) ** 2 + more))
    return (max(gain - both - BEYOND * below, 0.0), gain + BEYOND * error), both / gain
