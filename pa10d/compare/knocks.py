"""An error that lies in a few short stretches of time: a knock, a hand, a glitch of a sensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.words import percent
from pa10d.judgement.residuals import RunResidual
from pa10d.judgement.scores import moving
from pa10d.measurement.standstill import since_rest

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

STRETCH = 0.25  # s
MOST = 0.8  # of the squared error ...
SHORT = 0.1  # ... in so little of the time; noise of any colour that is over within it has no more
FEWEST = 40  # stretches: of fewer one is more than a tenth
START = 0.5  # s after a rest: what has stuck has let go, and the band shows it
BY_CHANCE = 0.01  # so seldom stretches that have nothing to do with it lie there
ONLY_THERE = "a knock, a hand, a glitch, or what the arm does only there"
AFTER_RESTS = (
    "where the joint moves on after it has stood, most of it: a brake that lets go late, or "
    "friction, grease or a seal that has stiffened at rest"
)


WHERE_SLOW = (
    "all of it where the joint is slower than {}, as it comes to rest, turns round or moves on: "
    "friction there is not as the model has it"
)


@dataclass(frozen=True)
class Knocks:
    """share of a joint's squared error in ``seconds`` of ``of`` s that are judged; the worst of
    them lies ``at`` s of ``run``; after_rests: they are where the joint moves on after a rest;
    slower_than: speed and unit, if all of them are worst where it is as slow as it seldom is."""

    share: float
    seconds: float
    of: float
    run: str
    at: float
    after_rests: bool = False
    slower_than: str = ""

    @property
    def words(self) -> str:
        """``96 % of its squared error lies in 0.9 of 16 s, …``."""
        return (
            f"{percent(self.share)} of its squared error lies in {self.seconds:.2g} of "
            f"{self.of:.2g} s, the worst of it at {self.at:.3g} s of {self.run}: "
            f"{self._there}. Look at it over time; "
            "identify --robust fits beside such stretches, --leave-out without them"
        )

    @property
    def _there(self) -> str:
        if self.after_rests:
            return AFTER_RESTS
        return WHERE_SLOW.format(self.slower_than) if self.slower_than else ONLY_THERE


@dataclass(frozen=True)
class Moments:
    """Which of some stretches (K,) hold most of a squared error in little of the time. Of each:
    power, time (s), its run's number, and s at which it begins there, all (K,)."""

    few: Mask
    power: Array
    time: Array
    run: NDArray[np.intp]
    begins: Array

    @property
    def share(self) -> float:
        """Of the squared error."""
        return float(self.power[self.few].sum() / self.power.sum())

    @property
    def seconds(self) -> float:
        """They last together."""
        return float(self.time[self.few].sum())

    @property
    def dense(self) -> float:
        """Share of squared error over share of time."""
        return self.share / (self.seconds / float(self.time.sum()))


def few_moments(runs: Sequence[tuple[Array, Mask, float]]) -> Moments | None:
    """Of an error (M,), where it counts, and samples per second, of each run. None: it is there all
    the time."""
    found = [_stretches(*run) for run in runs]
    power, time = (np.concatenate(both) for both in zip(*found, strict=True))
    if np.sum(time > 0.0) < FEWEST or not power.any():
        return None
    order = np.argsort(-power)
    count = int(np.searchsorted(np.cumsum(power[order]), MOST * power.sum())) + 1
    few = np.zeros(len(power), dtype=bool)
    few[order[:count]] = True
    counts = [len(one) for one, _ in found]
    begins = STRETCH * np.concatenate([np.arange(k, dtype=float) for k in counts])
    moments = Moments(few, power, time, np.repeat(np.arange(len(runs)), counts), begins)
    return moments if moments.seconds <= SHORT * time.sum() else None


def _stretches(error: Array, counts: Mask, rate: float) -> tuple[Array, Array]:
    """Squared error, and seconds that count, of each stretch of a run."""
    index = _stretch_of(len(counts), rate)
    power = np.bincount(index, np.where(counts, error, 0.0) ** 2)
    return power.astype(float), np.bincount(index, counts) / rate


def _stretch_of(samples: int, rate: float) -> NDArray[np.intp]:
    return (np.arange(samples) / (rate * STRETCH)).astype(np.intp)


def knocks(runs: Sequence[RunResidual], joint: int) -> Knocks | None:
    """Of the judged error of all runs together; None where it is not so."""
    used = moving(list(runs), joint)
    parts = [(run.error[:, joint], run.judged[:, joint], run.equation.rate) for run in used]
    found = few_moments(parts) if parts else None
    if found is None:
        return None
    worst, of = int(np.argmax(found.power)), float(found.time.sum())
    run, begins = used[found.run[worst]].name, float(found.begins[worst])
    after = _after_rests(used, joint, found)
    slow = "" if after else _slower_than(used, joint, found)
    return Knocks(found.share, found.seconds, of, run, begins, after, slow)


def _slower_than(runs: Sequence[RunResidual], joint: int, found: Moments) -> str:
    """The speed below which the joint is in so little of the time, where each of the stretches is
    worst below it, which what has nothing to do with the speed is seldom enough; else nothing."""
    speed = [np.abs(run.decimated(run.seen.dq))[:, joint] for run in runs]
    judged = [run.judged[:, joint] for run in runs]
    limit = float(np.quantile(np.concatenate(speed)[np.concatenate(judged)], SHORT))
    few = np.flatnonzero(found.few)
    worst = []
    for k in few:
        run, number = runs[found.run[k]], round(found.begins[k] / STRETCH)
        there = run.judged[:, joint] & (_stretch_of(len(run.error), run.equation.rate) == number)
        size = np.where(there, np.abs(run.error[:, joint]), 0.0)
        worst.append(speed[found.run[k]][int(np.argmax(size))])
    if max(worst) > limit or SHORT ** len(few) > BY_CHANCE:
        return ""
    return f"{limit:.2g} {runs[0].model.robot.angle_unit(joint)}/s"


def _after_rests(runs: Sequence[RunResidual], joint: int, found: Moments) -> bool:
    """Does it lie where the joint has just moved on after a rest, and more of the stretches than by
    chance? Not where as it comes to rest the error is much the same: what happens at low speed is
    no matter of having stood."""
    begins, parts = [], []
    for number, run in enumerate(runs):
        rate, speed = run.equation.rate, run.seen.dq[:, joint]
        moved = run.decimated(since_rest(speed, 1.0 / run.seen.dt)) < START
        begins.append(_stretches(np.ones(len(moved)), moved, rate)[1] > 0.0)
        few = found.few[found.run == number][_stretch_of(len(moved), rate)]
        error = np.where(run.judged[:, joint] & few, run.error[:, joint], 0.0)
        parts.append((np.sum(error[moved] ** 2), np.sum(error**2)))
    after, counted = np.concatenate(begins), found.time > 0.0
    lies, whole = np.sum(parts, axis=0)
    hit, of = int(np.sum(found.few & after)), int(found.few.sum())
    chance = scipy.stats.binom.sf(hit - 1, of, float(np.mean(after[counted])))
    return bool(lies > MOST * whole and chance < BY_CHANCE)
