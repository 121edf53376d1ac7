"""One joint's gain from its rows, with what its error is made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.identify.scale.rows import (
    SEEN,
    WeighingEquations,
    error_of_weights,
    error_over_blocks,
    outside,
    without,
)
from pa10d.identify.scale.spread import run_by_run

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Regression:
    """gain: measured torque over true torque; of_noise, of_body: standard errors of it; disagree,
    spread: whether recordings do by more than chance, and then the standard deviation of the gain
    from run to run; repeats: as many equally good runs as the loaded ones are worth."""

    gain: float
    of_noise: float
    of_body: float
    disagree: bool = False
    spread: float = 0.0
    repeats: float = 1.0

    @property
    def std_error(self) -> float:
        """Of the gain, by noise and weights together."""
        return float(np.hypot(self.of_noise, self.of_body))


def regression(rows: WeighingEquations) -> tuple[Regression | None, Array]:
    """None where the weights ask nothing that is not asked by all else; and what no gain explains
    (M,): where runs can be told apart, no gain of their own."""
    basis = outside(np.column_stack([rows.rubbing, rows.others]))
    left, x = without(rows.torque, basis), without(rows.asked, basis)
    power = float(x @ x)
    if power <= SEEN * float(rows.asked @ rows.asked) or power == 0:
        return None, left
    gain = float(x @ rows.torque) / power
    body = abs(gain) * error_of_weights(x, rows) / power  # more load than thought looks like gain
    each = run_by_run(rows, basis)
    if each is None:
        left = left - gain * x
        return Regression(gain, error_over_blocks(x * left, rows.blocks) / power, body), left
    share = (x @ each.loaded) / power
    noise, disagree, spread = each.error_of(gain, share)
    repeats = 1 / float(share @ share)
    return Regression(gain, noise, body, disagree, spread, repeats), each.left
