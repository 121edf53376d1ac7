"""Samples of a run brought to equal steps, all channels alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pa10d.measurement.sampling import Resampler, Timing, analyse, merge_duplicates, merged
from pa10d.measurement.scattered_stamps import evened
from pa10d.store.channels import Array, CommandedMotion, Samples

GAP = "gap"  # the extra channel that is 1 where nothing was measured


def equal_steps(t: Array, samples: Samples) -> tuple[Timing, Samples]:
    """``t`` (N,) s, never falling, N ≥ 2 different ones: the samples on ``timing.grid``.

    Stamps that scatter about equal steps in which the positions were read are set right. Samples of
    one stamp become their mean. Positions, velocities, torques and commands share one
    interpolation kernel; temperature, current and further channels are joined by straight lines.
    """
    starts = merge_duplicates(t)
    kept = t if starts is None else t[starts]
    if starts is not None:
        samples = _each(samples, lambda values, smooth: merged(values, starts))
    timing = analyse(kept, duplicates=len(t) - len(kept))
    if timing.resampled and (due := evened(kept, samples.q)) is not None:
        scatter = float(np.abs(kept - due).max())
        kept = due
        timing = replace(analyse(kept, timing.duplicates), scatter=scatter)
    if timing.resampled:
        on_grid = Resampler(kept, timing)
        samples = _each(samples, lambda values, smooth: _resampled(on_grid, values, smooth))
        if timing.gaps:
            samples = replace(samples, extra={**samples.extra, GAP: on_grid.in_gap()})
    return timing, replace(samples, stamps=np.rint(timing.grid * 1e9).astype(np.int64))


def _resampled(on_grid: Resampler, values: Array, smooth: bool) -> Array:
    if values.ndim == 1:
        return on_grid([values], smooth)[0]
    return np.stack(on_grid(list(values.T), smooth), axis=1)


def _each(samples: Samples, change: Callable[[Array, bool], Array]) -> Samples:
    """``change(values, smooth)`` applied to every channel."""

    def maybe(values: Array | None, smooth: bool) -> Array | None:
        return None if values is None else change(values, smooth)

    sent = samples.commands
    return replace(
        samples,
        q=change(samples.q, True),
        tau=change(samples.tau, True),
        dq=maybe(samples.dq, True),
        commands=sent
        and CommandedMotion(change(sent.q, True), change(sent.dq, True), change(sent.tau, True)),
        temperature=maybe(samples.temperature, False),
        current=maybe(samples.current, False),
        extra={name: change(values, False) for name, values in samples.extra.items()},
    )
