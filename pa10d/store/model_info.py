"""What is known of a model without its parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from pa10d.common.version import __version__


@dataclass(frozen=True)
class ModelInfo:
    """rms: of the fit; held_out: run -> RMS (n,); noise_floor (n,): all N·m, filtered.

    parent: id of the model it was made from; replaced: a later model took its name
    """

    id: str
    name: str
    created: str  # UTC, ISO 8601
    robot: str
    joints: tuple[str, ...]
    change: str
    effects: tuple[str, ...]  # stribeck J4
    runs: tuple[str, ...]
    cutoff_hz: float
    feasible: bool
    rms: tuple[float, ...]
    held_out: dict[str, tuple[float, ...]]
    noise_floor: tuple[float, ...] | None = None
    parent: str | None = None
    parent_name: str | None = None
    software: str = f"pa10d {__version__}"
    replaced: bool = False

    def but(self, **changes: Any) -> ModelInfo:
        """A copy with these changes."""
        return replace(self, **changes)
