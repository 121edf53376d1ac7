"""Channels of runs and of faults, for whoever looks: as many points as a screen has.

Called by the viewer, which keeps what it read: a zoom is then a slice.
"""

from __future__ import annotations

import base64
import contextlib
import math
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
import scipy.signal
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.compare.angle_periodogram import TURNS, periodogram
from pa10d.compare.order_lines import slow_part
from pa10d.figures.columns import arrow_stream
from pa10d.services import plots
from pa10d.services.channels import (
    Source,
    add_model,
    source_of_fault,
    source_of_run,
)
from pa10d.services.fault_records import FaultList, read_fault
from pa10d.services.robots import load_robot
from pa10d.services.viewed import Channels

Array = NDArray[np.float64]
Kind = Literal["run", "fault"]
Span = list[float] | None

SOURCES = 6  # kept in memory
SEGMENTS = 8  # of a stretch that a spectrum is the mean of, where it is long enough
LEAST = 4.0  # s of a segment
LINES = 4000  # of a spectrum that are sent
STILL = 0.02  # of the highest speed, below which a joint is at rest for the orders
MOST = 200_000  # samples of an order spectrum
HIGHEST_ORDER = 1000.0  # cycles/rev


def channels(data: str, profile: str, kind: Kind, name: str, models: Sequence[str]) -> Channels:
    """What there is of a run (id) or a fault, and of what models (ids) say of it."""
    return _source_of(data, profile, kind, name, models).listed


def columns(
    data: str,
    profile: str,
    kind: Kind,
    name: str,
    models: Sequence[str],
    wanted: Sequence[str],
    span: Span,
    points: int,
    every: bool,
) -> str:
    """A stretch of channels, base64 of an Arrow stream: ``time`` (s since the recording's first
    sample), and a column of each channel.

    Smallest and largest value of each of points/2 pieces, in their order; every: samples at equal
    distances instead, which belong together across columns.
    """
    source = _source_of(data, profile, kind, name, models)
    first, last = _samples(source, span)
    made: dict[str, NDArray[Any]] = {}
    begin, step = float(first), float(max(1, math.ceil((last - first) / points)))
    for channel in wanted:
        pyramid = source.get(channel)
        if every:
            made[channel] = pyramid.fine[first : last : int(step)]
        else:
            made[channel], begin, step = pyramid.stretch(first, last, points)
    length = len(next(iter(made.values())))
    time = (begin + step * np.arange(length)) * source.dt
    units = {channel: source.channels[channel].unit for channel in wanted}
    about = {"start": source.start, "dt": source.dt, "step": step * source.dt, "units": units}
    return base64.b64encode(arrow_stream({"time": time, **made}, about)).decode()


def spectrum(
    data: str,
    profile: str,
    kind: Kind,
    name: str,
    models: Sequence[str],
    wanted: Sequence[str],
    span: Span,
    orders: bool,
) -> str:
    """Amplitudes of sines in a stretch, base64 of an Arrow stream.

    Against ``frequency`` (Hz): the mean of Hann-windowed segments (Welch), of 4 s at least; a sine
    between two lines loses at most 1.4 dB. Against ``order`` (cycles per revolution of the
    channel's joint): least squares over the angle while the joint moves, its slow curve taken out.
    """
    source = _source_of(data, profile, kind, name, models)
    first, last = _samples(source, span)
    made: dict[str, NDArray[Any]] = {}
    axis: Array | None = None
    for channel in wanted:
        signal = source.get(channel).fine[first:last].astype(float)
        if not np.isfinite(signal).all():
            raise UserError(f"channel {channel!r}: values are missing in this stretch")
        joint = source.channels[channel].joint
        if not orders:
            axis, made[channel] = _frequencies(signal, 1.0 / source.dt)
        elif joint is None:
            raise UserError(f"channel {channel!r} belongs to no joint, so it has no orders")
        else:
            q, dq = (source.get(f"{s}{joint}").fine[first:last].astype(float) for s in ("q", "dq"))
            axis, made[channel] = _orders(q, dq, signal)
    assert axis is not None
    about = {"units": {channel: source.channels[channel].unit for channel in wanted}}
    table = {"order" if orders else "frequency": axis, **made}
    return base64.b64encode(arrow_stream(table, about)).decode()


def faults(data: str) -> FaultList:
    """Every fault whose last seconds were kept, newest first."""
    kept = []
    for path in sorted(_faults(data).glob("*.npz"), reverse=True):
        with contextlib.suppress(UserError):
            kept.append(read_fault(path).brief)
    return FaultList(kept)


def _source_of(data: str, profile: str, kind: Kind, name: str, models: Sequence[str]) -> Source:
    """A run that is still being recorded is read anew as it grows."""
    if kind == "fault":
        return _source(data, profile, kind, name, (), 0)
    library = plots.library_of(data)
    run = library.runs.find(name)  # by ids: another may bear the name by now
    known = tuple(library.models.find(model).id for model in models)
    return _source(data, profile, kind, run.id, known, run.samples)


@lru_cache(SOURCES)
def _source(
    data: str, profile: str, kind: Kind, name: str, models: tuple[str, ...], samples: int
) -> Source:
    if kind == "fault":
        path = _faults(data) / f"{name}.npz"
        if name not in {one.stem for one in _faults(data).glob("*.npz")}:
            raise UserError(f"fault {name[:60]!r}: there is no such record")
        return source_of_fault(path)
    library = plots.library_of(data)
    info = library.runs.find(name)
    source = source_of_run(info.name, library.runs.read(info), load_robot(profile)[1])
    for model in models:
        found = plots.model_of(data, model)
        seen = plots.residual_in_own_band(data, model, info.id)
        add_model(source, found.name, seen, found.terms)
    return source


def _faults(data: str) -> Path:
    return Path(data) / "faults"


def _samples(source: Source, span: Span) -> tuple[int, int]:
    """First and one past the last sample of a stretch, s since the first sample; two at least."""
    if span is None:
        return 0, source.count
    first = min(max(0, math.floor(span[0] / source.dt)), max(0, source.count - 2))
    last = min(source.count, math.ceil(span[1] / source.dt) + 1)
    return first, max(first + 2, last)


def _frequencies(signal: Array, rate: float) -> tuple[Array, NDArray[np.float32]]:
    length = len(signal)
    segment = max(min(length, int(LEAST * rate)), 2 * length // (SEGMENTS + 1))
    f, power = scipy.signal.welch(
        signal, rate, nperseg=segment, detrend="linear", scaling="spectrum"
    )
    return _sent(f, np.sqrt(2 * power))


def _orders(q: Array, dq: Array, signal: Array) -> tuple[Array, NDArray[np.float32]]:
    moving = np.abs(dq) > STILL * np.abs(dq).max()
    every = max(1, math.ceil(int(moving.sum()) / MOST))
    q, dq, signal = (values[moving][::every] for values in (q, dq, signal))
    if len(q) < 100 or np.ptp(q) <= 0:
        raise UserError("the joint hardly moves in this stretch; expected a motion for its orders")
    order = np.arange(TURNS, HIGHEST_ORDER * TURNS + 1) / TURNS
    left = signal - slow_part(q, dq, signal)
    share = periodogram(q, left, order)[0]
    return _sent(order, np.sqrt(2 * np.mean(left**2) * share))


def _sent(axis: Array, amplitude: Array) -> tuple[Array, NDArray[np.float32]]:
    """What a screen can show. With several channels all have one axis, so lines are merged
    blockwise and not where each has its own peaks."""
    width = max(1, math.ceil(len(axis) / LINES))
    if width == 1:
        return axis, amplitude.astype(np.float32)
    whole = len(axis) // width * width
    highest = amplitude[:whole].reshape(-1, width).max(axis=1)
    return axis[width // 2 : whole : width], highest.astype(np.float32)
