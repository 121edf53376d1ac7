"""Plots on demand, for a page: short functions of names, numbers and a data folder.

They run in one process that remembers the last runs it read: zooming is then a slice.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject, plain
from pa10d.common.words import from_one
from pa10d.compare.quantities import Values, quantities
from pa10d.figures import TEXTS
from pa10d.figures.evidence import before_after
from pa10d.figures.plotly import Figure
from pa10d.figures.recorded import recorded
from pa10d.figures.staircase import Stair, staircase, staircase_text
from pa10d.figures.texts import Reading
from pa10d.figures.time import pauses, torque_over_time
from pa10d.judgement import (
    Judgement,
    RunResidual,
    common_band,
    in_band,
    judged,
    run_residual,
    with_one_floor,
)
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass
from pa10d.model import TorqueModel
from pa10d.services.library import Library, open_library

Array = NDArray[np.float64]
Plot = JsonObject

READ = 6  # runs and models kept in memory
JUDGED = 6  # the same as one model sees them
WARM = 100  # samples that are filtered for nothing
AROUND = 4.0  # s at least that are shown around a place


def warm_up() -> None:
    """Importing this module takes time, and so does loading the compiled filter."""
    Lowpass(WARM, float(WARM), 1.0)(np.zeros((WARM, 1)))


def run_plot(data: str, run: str, span: list[float] | None) -> Plot:
    """A recording: positions and torques."""
    library = library_of(data)
    info = library.runs.find(run)
    return _plot(recorded(_recording(data, info.id), info.joints, _span(span)))


def torque_over(
    data: str,
    model: str,
    run: str,
    joint: int,
    raw: bool,
    span: list[float] | None,
    place: tuple[str, float, float] | None,
) -> Plot:
    """Measured and modelled torque of one joint (from 1). place: a quantity and its range, as
    ``where`` of a comparison has them: shown in red, and ``jump`` is the stretch that shows it."""
    library = library_of(data)
    pair = library.models.find(model).id, library.runs.find(run).id
    band = common_band(model_of(data, info.id) for info in library.models.history(pair[0]))
    seen = _residual(data, *pair, band)
    _refuse_joint(seen, joint)
    marked = None if place is None else _within(seen, joint - 1, *place)
    level = float(_judged_alike(data, pair[:1], pair[1:], band)[0].floor.values[joint - 1])
    floor = level if np.isfinite(level) else None
    figure = torque_over_time(seen, joint - 1, floor, raw=raw, span=_span(span), marked=marked)
    jump = None if marked is None else _stretch(seen, joint - 1, marked)
    return _plot(figure, TEXTS["time"].told(floor is not None), jump=jump)


def staircase_of(data: str, model: str, runs: Sequence[str]) -> Plot:
    """The errors of a model and of all it was made from, on the same runs."""
    library = library_of(data)
    line = library.models.history(library.models.find(model))
    ids = _ids(library, runs)
    band = common_band(model_of(data, info.id) for info in line)
    found = _judged_alike(data, [info.id for info in line], ids, band)
    steps = [Stair(info.name, info.change, one.rms) for info, one in zip(line, found, strict=True)]
    floor = found[-1].floor.values
    figure = staircase(steps, line[-1].joints, floor)
    told = [{"model": s.name, "change": s.change, "rms": s.rms.tolist()} for s in steps]
    return _plot(
        figure,
        staircase_text(floor),
        steps=told,
        noise_floor=plain(floor),
        units=_units(model_of(data, line[-1].id)),
        hidden=[j + 1 for j in found[-1].hidden],
        **_named(found[-1]),
    )


def versus(data: str, one: str, other: str, runs: Sequence[str]) -> Plot:
    """Two models side by side on the same runs."""
    library = library_of(data)
    first, second = library.models.find(one), library.models.find(other)
    ids = _ids(library, runs)
    band = common_band(model_of(data, info.id) for info in (first, second))
    found = _judged_alike(data, (first.id, second.id), ids, band)
    rms, floor = [one.rms for one in found], found[0].floor.values
    names = (first.name, second.name)
    figure = before_after(first.joints, rms[0], rms[1], floor, names)
    told = [r.tolist() for r in rms]
    return _plot(
        figure,
        TEXTS["versus"].told(bool(np.any(np.isfinite(floor)))),
        rms=told,
        noise_floor=plain(floor),
        units=_units(model_of(data, second.id)),
        **_named(found[0]),
    )


@lru_cache(1)
def library_of(data: str) -> Library:
    """The store behind a data folder."""
    return open_library(data)


@lru_cache(READ)
def _recording(data: str, run: str) -> Recording:
    return library_of(data).runs.recording(run)


@lru_cache(READ)
def model_of(data: str, model: str) -> TorqueModel:
    """A stored model, by its id."""
    return library_of(data).models.load(model)


@lru_cache(JUDGED)
def _residual(data: str, model: str, run: str, band: float) -> RunResidual:
    return run_residual(in_band(model_of(data, model), band), _recording(data, run))


def residual_in_own_band(data: str, model: str, run: str) -> RunResidual:
    """A run (id) as a model (id) sees it, in the band that it shares with its ancestors."""
    line = library_of(data).models.history(model)
    return _residual(data, model, run, common_band(model_of(data, info.id) for info in line))


@lru_cache(256)
def _judged(data: str, model: str, runs: tuple[str, ...], band: float) -> Judgement:
    return judged(model, [_residual(data, model, run, band) for run in runs])


def _judged_alike(
    data: str, models: Sequence[str], runs: tuple[str, ...], band: float
) -> list[Judgement]:
    """Models with one floor, the least that they or any of their kin show on these runs."""
    library = library_of(data)
    kin = dict.fromkeys(
        one.id for model in models for one in library.models.family(library.models.find(model))
    )
    found = [_judged(data, model, runs, band) for model in models]
    for other in kin:
        if other not in models:
            with suppress(UserError):
                found.append(_judged(data, other, runs, band))
    return with_one_floor(found)[: len(models)]


def forget(data: str) -> None:
    """What was read of runs: another part of one counts now."""
    for known in (_recording, _residual, _judged):
        known.cache_clear()


def _units(model: TorqueModel) -> list[str]:
    return [model.robot.torque_unit(j) for j in range(model.robot.n)]


def _named(found: Judgement) -> JsonObject:
    return {"cutoff_hz": found.cutoff, "mask": found.mask}


def _ids(library: Library, runs: Sequence[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(library.runs.find(run).id for run in runs))


def _within(seen: RunResidual, joint: int, variable: str, low: float, high: float) -> Any:
    """(M,) True where the quantity lies in the range and the error counts."""
    warm = seen.seen.temperature is not None
    known = {q.name: q for q in quantities(seen.seen.robot, joint, warm)}
    if variable not in known:
        raise UserError(f"variable {variable!r}: expected one of {', '.join(known)}")
    values = Values(seen)(known[variable])
    return (values >= low) & (values <= high) & seen.counts[:, joint]


def _stretch(seen: RunResidual, joint: int, marked: NDArray[np.bool_]) -> list[float] | None:
    """(begin, end) s around the marked piece that carries most squared error."""
    dt = 1.0 / seen.equation.rate
    pieces = pauses(~marked, dt, shortest=0)
    if not pieces:
        return None
    square = np.concatenate([[0.0], np.cumsum(seen.error[:, joint] ** 2)])
    carried = [square[round(b / dt)] - square[round(a / dt)] for a, b in pieces]
    begin, end = pieces[int(np.argmax(carried))]
    margin = max(0.5 * (end - begin), 0.5 * (AROUND - (end - begin)))
    return [max(0.0, begin - margin), min(len(marked) * dt, end + margin)]


def _refuse_joint(seen: RunResidual, joint: int) -> None:
    if not 1 <= joint <= seen.seen.robot.n:
        raise UserError(f"joint {joint}: expected {from_one(seen.seen.robot.n)}")


def _span(span: list[float] | None) -> tuple[float, float] | None:
    return None if span is None else (span[0], span[1])


def _plot(figure: Figure, reading: Reading | None = None, **more: Any) -> Plot:
    words = {"read": reading.read, "then": reading.then} if reading else {"read": "", "then": ""}
    return {"figure": figure, **words, **more}
