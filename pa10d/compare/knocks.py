"""An error that lies in a few short stretches of time: a knock, a hand, a glitch of a sensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import percent
from pa10d.judgement.residuals import RunResidual
from pa10d.judgement.scores import moving

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

STRETCH = 0.25  # s
MOST = 0.8  # of the squared error ...
SHORT = 0.1  # ... in so little of the time; noise of any colour that is over within it has no more
FEWEST = 40  # stretches: of fewer one is more than a tenth


@dataclass(frozen=True)
class Knocks:
    """share of a joint's squared error in ``seconds`` of ``of`` s that are judged; the worst of
    them lies ``at`` s of ``run``."""

    share: float
    seconds: float
    of: float
    run: str
    at: float

    @property
    def words(self) -> str:
        """``96 % of its squared error lies in 0.9 of 16 s, …``."""
        return (
            f"{percent(self.share)} of its squared error lies in {self.seconds:.2g} of "
            f"{self.of:.2g} s, the worst of it at {self.at:.3g} s of {self.run}: "
            "a knock, a hand, a glitch, or what the arm does only there. Look at it over time; "
            "identify --robust fits beside such stretches, --leave-out without them"
        )


def concentrated(power: Array, time: Array) -> Mask | None:
    """Which of some stretches (K,), each with so much of a squared error in so many seconds, hold
    most of it in little of the time; None where they do not."""
    if len(power) < FEWEST or not power.any():
        return None
    order = np.argsort(-power)
    count = int(np.searchsorted(np.cumsum(power[order]), MOST * power.sum())) + 1
    few = np.zeros(len(power), dtype=bool)
    few[order[:count]] = True
    return few if time[few].sum() <= SHORT * time.sum() else None


def stretches(error: Array, counts: Mask, rate: float) -> tuple[Array, Array]:
    """Squared error, and seconds that count, of each stretch of a run sampled at so many Hz."""
    index = (np.arange(len(counts)) / (rate * STRETCH)).astype(int)
    power = np.bincount(index, np.where(counts, error, 0.0) ** 2)
    return power.astype(float), np.bincount(index, counts) / rate


def knocks(runs: Sequence[RunResidual], joint: int) -> Knocks | None:
    """Of the judged error of all runs together; None where it is not so."""
    used = moving(list(runs), joint)
    if not used:
        return None
    parts = [stretches(r.error[:, joint], r.judged[:, joint], r.equation.rate) for r in used]
    places = [
        (run.name, k * STRETCH)
        for run, part in zip(used, parts, strict=True)
        for k in range(len(part[0]))
    ]
    power, time = (np.concatenate(both) for both in zip(*parts, strict=True))
    judged = time > 0.0
    few = concentrated(power[judged], time[judged])
    if few is None:
        return None
    worst = places[int(np.argmax(power))]
    share = float(power[judged][few].sum() / power.sum())
    return Knocks(share, float(time[judged][few].sum()), float(time.sum()), *worst)
