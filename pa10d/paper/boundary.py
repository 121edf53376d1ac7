"""The boundary velocity: above it, friction is Coulomb plus viscous (paper 2.2, eq. 6-7).

The paper raises a threshold, solves (7) with the samples faster than it, and watches where the
inertia stops changing. That is done here with bands from a bootstrap over whole swings. But an
estimate of inertia is blind to friction that is a function of speed alone: over a closed swing
∫F(q̇)·q̈ dt = ∮F dq̇ = 0. Only friction with memory moves it. So the friction map itself is asked as
well: which of its slowest speeds does the straight line through the faster ones not explain?
The threshold is the larger of the two answers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.paper.friction_map import FrictionMap, friction_map, knee, knee_spread
from pa10d.paper.single_joint import GRAVITY, JointEquation
from pa10d.paper.sweep import Sweep, sweep
from pa10d.paper.told import ToldBoundary

Array = NDArray[np.float64]

LEAST_SWINGS = 6
REPLICATES = 400
MATERIAL = 0.02  # of the inertia, of the Coulomb level: smaller deviations do not count


@dataclass(frozen=True)
class BoundaryVelocity:
    """threshold rad/s with its standard error and 90 % interval; decided_by: "friction map" or
    "inertia" or "none" (friction is linear as far down as the data reach: ``finest``)."""

    joint: int
    threshold: float
    std_error: float
    interval: tuple[float, float]
    decided_by: str
    finest: float
    from_inertia: float
    from_map: float
    sweep: Sweep
    map: FrictionMap
    gravity: str

    @property
    def sentence(self) -> str:
        """In words."""
        j = self.joint + 1
        if self.decided_by == "none":
            return (
                f"joint {j}: friction is linear down to {self.finest:.2g} rad/s, the slowest speed "
                f"that these data resolve; {self.gravity}"
            )
        return (
            f"joint {j}: friction is linear above {self.threshold:.3f} ± {self.std_error:.3f} "
            f"rad/s (by the {self.decided_by}); {self.gravity}"
        )

    def told(self) -> ToldBoundary:
        """For whoever is told of it elsewhere."""
        return ToldBoundary(
            joint=self.joint + 1,
            threshold=self.threshold,
            std_error=self.std_error,
            interval=self.interval,
            decided_by=self.decided_by,
            finest=self.finest,
            from_inertia=self.from_inertia,
            from_map=self.from_map,
            gravity=self.gravity,
            sentence=self.sentence,
            sweep=self.sweep.told(),
            friction_map=self.map.told(),
        )


def boundary_velocity(data: JointEquation, seed: int = 1) -> BoundaryVelocity:
    """Threshold, bands and friction map of one joint."""
    swings = len(data.runs)
    if swings < LEAST_SWINGS:
        raise UserError(
            f"joint {data.joint + 1}: {swings} whole swings, expected at least {LEAST_SWINGS}: the "
            "spread between swings is what the bands come from"
        )
    draws = data.draws(REPLICATES, seed)
    charted = friction_map(data, draws)
    curve = sweep(data, draws, charted.nuisance, charted.nuisance_replicates, MATERIAL)
    place = knee(charted, MATERIAL)
    spread = knee_spread(charted, MATERIAL)
    finest = float(charted.edges[0])
    from_map = 0.0 if place == 0 else float(charted.edges[place])
    by_map = from_map >= curve.converged_from
    threshold = max(from_map, curve.converged_from)
    if threshold == 0.0:
        decided, error, interval = "none", finest, (0.0, finest)
    elif by_map:
        before, after = float(charted.edges[place - 1]), float(charted.edges[place + 1])
        error = float(np.hypot(spread.std(), (after - before) / np.sqrt(48)))
        low, high = np.quantile(spread, [0.05, 0.95])
        decided = "friction map"
        interval = (min(float(low), before), max(float(high), after))
    else:
        step = curve.resolution(threshold)
        decided, error = "inertia", step / np.sqrt(12)
        interval = (threshold - step, threshold + step)
    return BoundaryVelocity(
        data.joint, threshold, error, interval, decided, finest, curve.converged_from, from_map,
        curve, charted, GRAVITY[data.gravity],
    )  # fmt: skip
