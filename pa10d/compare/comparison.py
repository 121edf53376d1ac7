"""A model against recordings: how large the error is, where it is, and what it looks like."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.words import listed
from pa10d.compare.above_band import lines_above_band
from pa10d.compare.frequencies import FrequencySpectrum, frequency_spectrum
from pa10d.compare.orders import OrderSpectrum, order_spectrum
from pa10d.compare.places import Place, failing, places
from pa10d.compare.unexplained import map_warnings
from pa10d.compare.whiteness import Whiteness, whiteness
from pa10d.judgement import (
    MASK,
    MATERIAL,
    Judgement,
    NoiseFloor,
    RunResidual,
    Scores,
    beside_its_own,
    hidden_in,
    in_band,
    judged,
    least_floor,
    mask_of,
    of_own_runs,
    or_of_own_runs,
    run_residual,
    scores,
    through,
)
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel
from pa10d.regression.noisy_limits import sharing_limits

Array = NDArray[np.float64]
Progress = Callable[[float, str], None]


@dataclass(frozen=True)
class RunScores:
    """One run's figures, or those of all together; where: its own regions; spread: in words, the
    joints that keep materially more than noise of which no region stands out; mask: which samples
    count."""

    name: str
    scores: Scores
    floor: NoiseFloor
    where: tuple[Place, ...]
    spread: tuple[str, ...] = ()
    mask: str = MASK

    @property
    def noise_floor(self) -> Array:
        """(n,) N·m."""
        return self.floor.values

    @property
    def by_noise(self) -> bool:
        """Whether the noise of any joint is known, so that joints can be ranked by it."""
        return bool(np.any(np.isfinite(self.noise_floor)))

    @property
    def standing(self) -> Array:
        """(n,): RMS over the noise floor, nan where that is not known; where it is known of no
        joint, RMS over the range of the measured torque."""
        return self.scores.rms / self.noise_floor if self.by_noise else self.scores.nrmse

    @property
    def worst(self) -> int:
        """The joint (0-based) that stands out most."""
        return int(np.nanargmax(self.standing))


@dataclass(frozen=True)
class Comparison:
    """Everything that compare finds. Lists of spectra and whiteness have one entry per joint.

    model: with the band that it was judged in
    beside: how the models beside it are judged on the same runs, with the same floor; None where
    the runs lack what one needs
    """

    model: TorqueModel
    residuals: tuple[RunResidual, ...]
    runs: tuple[RunScores, ...]
    pooled: RunScores
    orders: tuple[OrderSpectrum | None, ...]
    frequencies: tuple[FrequencySpectrum, ...]
    whiteness: tuple[Whiteness, ...]
    warnings: tuple[str, ...] = field(default=())
    beside: tuple[Judgement | None, ...] = field(default=())


def compare(
    model: TorqueModel,
    recordings: Sequence[Recording],
    progress: Progress = lambda share, what: None,
    cutoff: float | None = None,
    beside: Sequence[TorqueModel] = (),
) -> Comparison:
    """Judge the model on every recording and on all of them together.

    progress(share done in 0…1, what is being done)
    cutoff: Hz of the low-pass on both sides; default: the model's own band
    beside: further models of the same arm, through which the noise may be seen more clearly
    """
    if not recordings:
        raise UserError("nothing to compare with: expected at least one run")
    given, model = model, in_band(model, cutoff)
    recordings = sharing_limits(recordings, model.robot)
    residuals = []
    for index, recording in enumerate(recordings):
        progress(0.2 * index / len(recordings), f"run {recording.name}")
        residuals.append(run_residual(model, recording))
    others: list[list[Judgement] | None] = []
    for other in beside:
        progress(0.2 + 0.1 * len(others) / len(beside), f"noise through {other.name}")
        views = through(other, recordings, model.cutoff)
        others.append(_apart_and_together(other.name, views) if views else None)
    seen = [_apart_and_together(model.name, residuals), *(one for one in others if one)]
    least = [least_floor([one.floor for one in each]) for each in zip(*seen, strict=True)]
    known = of_own_runs([given, *beside], model.cutoff)
    floors = [_floor_of(one, floor, known) for one, floor in zip(seen[0], least, strict=True)]
    own: list[RunScores] = []
    for run, floor in zip(residuals, floors, strict=False):
        progress(0.3 + 0.3 * len(own) / len(recordings), f"run {run.name}")
        own.append(_of(run.name, [run], model, floor))
    progress(0.6, "all runs together")
    pooled = own[0] if len(own) == 1 else _of("pooled", residuals, model, floors[-1])
    progress(0.8, "spectra")
    orders = tuple(
        None if slides else order_spectrum(residuals, j)
        for j, slides in enumerate(model.robot.prismatic)
    )
    joints = range(model.robot.n)
    return Comparison(
        model=model,
        residuals=tuple(residuals),
        runs=tuple(own),
        pooled=pooled,
        orders=orders,
        frequencies=tuple(frequency_spectrum(residuals, j) for j in joints),
        whiteness=tuple(whiteness(residuals, j) for j in joints),
        warnings=(
            *_warnings(residuals),
            *_fitted_too(model, residuals),
            *_above_band(orders, model.cutoff, pooled.scores.rms),
            *map_warnings(model, residuals),
        ),
        beside=tuple(
            replace(one[-1], floor=_floor_of(one[-1], least[-1], known)) if one else None
            for one in others
        ),
    )


def _apart_and_together(model: str, residuals: Sequence[RunResidual]) -> list[Judgement]:
    """Of every run, and last of all where there are several."""
    found = [judged(model, [run]) for run in residuals]
    return [*found, judged(model, residuals)] if len(found) > 1 else found


def _floor_of(one: Judgement, least: NoiseFloor, known: Array | None) -> NoiseFloor:
    """Of a model on some runs, with the least that any model shows of their noise; known: (n,) N·m
    of the models' own runs."""
    return or_of_own_runs(beside_its_own(least, one.floor), known, one.rms)


def _of(name: str, runs: list[RunResidual], model: TorqueModel, floor: NoiseFloor) -> RunScores:
    found = scores(runs)
    hidden = hidden_in(runs)
    where = [
        place
        for place in places(runs, model.robot, floor.values, judged=found)
        if place.joint not in hidden
    ]
    where += _clear_places(runs, found, floor, model, {place.joint for place in where} | {*hidden})
    spread = failing(found, floor.values, model.robot, where, runs, model.noise)
    return RunScores(name, found, floor, tuple(where), tuple(spread), mask_of(runs))


def _clear_places(
    runs: list[RunResidual],
    found: Scores,
    floor: NoiseFloor,
    model: TorqueModel,
    told: Collection[int],
) -> list[Place]:
    """Of joints that keep more than noise, of which none was told: places clear of reversals, as a
    diagnosis looks for them."""
    keeps = np.flatnonzero(found.rms > MATERIAL * floor.values).tolist()
    silent = [j for j in keeps if j not in told]
    return places(runs, model.robot, floor.values, joints=silent, clear=True) if silent else []


def _above_band(orders: Sequence[OrderSpectrum | None], cutoff: float, rms: Array) -> list[str]:
    found = lines_above_band(orders, cutoff, rms)
    return [f"joint {j + 1}: {text}" for j, text in found.items()]


def _fitted_too(model: TorqueModel, residuals: Sequence[RunResidual]) -> list[str]:
    """Runs that the fit has seen: an error on them says nothing of motions that it has not."""
    seen = [run.name for run in residuals if run.name in model.runs]
    if not seen:
        return []
    return [
        f"the model was fitted to {listed(seen)}: its error there is smaller than on a motion that "
        "it has not seen"
    ]


def _warnings(residuals: Sequence[RunResidual]) -> list[str]:
    return [
        f"run {run.name}: joint {j + 1} {_rests(run, j)}; its error there is friction at rest, "
        "which no model knows, or a brake holds it, or its torque is not measured"
        for run in residuals
        for j in run.rested
        if j not in run.hidden
    ]


def _rests(run: RunResidual, joint: int) -> str:
    lowpass = run.equation.lowpass
    seconds = float(run.equation.moving[:, joint].sum()) * lowpass.factor / lowpass.rate
    return f"moves clear of its rests for {seconds:.2g} s only" if seconds else "hardly moves"
