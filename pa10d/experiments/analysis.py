"""What a recorded experiment shows by itself, and what to do next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.control.limits import ArmLimits
from pa10d.store import StoredRun

Array = NDArray[np.float64]

LOOSE = 0.5  # of the following-error bound: tracking that is worth a word
HEAVY = 0.9  # of the torque limit: the drive may have saturated
WARMER = 3.0  # K over a run

NEXT = {
    "excitation": "fit a model to {runs}",
    "boundary_velocity": "use the boundary velocities to choose samples for a linear friction fit",
    "tracking": "judge a model by {runs}, or the controller",
    "point_to_point": "keep {runs} to judge models by",
    "velocity_sweep": "look for what friction does: diagnose a model with {runs}",
    "load_sweep": "look for friction that follows load: diagnose a model with {runs}",
    "reversals": "look for bristles and gaps: diagnose a model with {runs}",
    "warm_up": "look for friction that falls: diagnose a model with {runs}",
    "chirp": "look for springs and delays: diagnose a model with {runs}",
    "known_weight": "record it without and with a known weight: {runs} is one of the two",
    "first_motion": "the gains are set: record the starting set",
    "step": "change gains or the controller, step again, and look at {runs} beside it under Tune",
    "single_joint": "look at one joint: diagnose a model with {runs}",
}


@dataclass(frozen=True)
class TrackingFigures:
    """(n,) each: RMS and largest tracking error rad, largest torque N·m, warming K (or None)."""

    rms: Array
    worst: Array
    torque: Array
    warming: Array | None

    def document(self) -> JsonObject:
        """For JSON."""
        return {
            "tracking_rms": self.rms.tolist(),
            "tracking_max": self.worst.tolist(),
            "torque_max": self.torque.tolist(),
            "warming": None if self.warming is None else self.warming.tolist(),
        }


def tracking_of(run: StoredRun) -> TrackingFigures:
    """How well the arm followed."""
    samples = run.samples
    sent = samples.commands
    error = np.zeros_like(samples.q) if sent is None else sent.q - samples.q
    warming = None
    if samples.temperature is not None:
        warming = samples.temperature[-1] - samples.temperature[0]
    return TrackingFigures(
        np.sqrt(np.mean(error**2, axis=0)),
        np.abs(error).max(axis=0),
        np.abs(samples.tau).max(axis=0),
        warming,
    )


def recommendation(
    kind: str, names: list[str], found: list[TrackingFigures], limits: ArmLimits
) -> list[str]:
    """What a careful person would say next, most important first."""
    out = []
    for name, tracking in zip(names, found, strict=True):
        for j in np.flatnonzero(tracking.worst > LOOSE * limits.following_error):
            out.append(
                f"{name}: joint {j + 1} was {tracking.worst[j]:.3f} rad from its path at worst; "
                "raise control.bandwidth_hz or use computed torque with a model"
            )
        for j in np.flatnonzero(tracking.torque > HEAVY * limits.torque):
            out.append(
                f"{name}: joint {j + 1} needed {tracking.torque[j]:.0f} N·m, near its limit of "
                f"{limits.torque[j]:.0f}; run it slower or in other poses"
            )
        if tracking.warming is not None and np.nanmax(tracking.warming, initial=0.0) > WARMER:
            hot = int(np.nanargmax(tracking.warming))
            out.append(
                f"{name}: joint {hot + 1} warmed by {tracking.warming[hot]:.1f} K; "
                "friction may have changed, warm up before runs that shall agree"
            )
    return [*out, NEXT.get(kind, "compare a model with it").format(runs=" ".join(names))]
