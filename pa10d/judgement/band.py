"""The band in which a model is judged: two errors compare only behind the same low-pass.

White noise of one strength leaves √2 more behind twice the cut-off, so a version that was fitted
to a narrower band than its parent would look better without being so.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from pa10d.model import TorqueModel

HIGHEST_HZ = 12.0
"""Mechanical effects act within the band of the motion; above it a residual holds what reversals
and timing leave behind, which looks like any effect that is sharp."""

SHORT_MOTION = "short motion"
"""Why a cut-off is wider than it would be: the filter's memory of ends, rests and reversals would
have taken more than half of the motion."""


def band(model: TorqueModel) -> float:
    """Hz of the low-pass on both sides: the model's own, at most HIGHEST_HZ unless a user or the
    motion asked for more."""
    chosen = model.notes.cutoff
    if chosen is not None and chosen.chosen_by in ("user", SHORT_MOTION):
        return model.cutoff
    return min(model.cutoff, HIGHEST_HZ)


def common_band(models: Iterable[TorqueModel]) -> float:
    """Hz: the one band in which all of these are judged, the narrowest of their own."""
    return min(band(model) for model in models)


def in_band(model: TorqueModel, cutoff: float | None = None) -> TorqueModel:
    """The same model, to be fitted and judged behind ``cutoff`` Hz (default: its own band)."""
    return replace(model, cutoff=band(model) if cutoff is None else cutoff)
