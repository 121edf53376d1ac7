"""A boundary velocity as it is told: by whoever analysed the run, to whoever draws it elsewhere.

``None`` stands where a number was not finite.
"""

from __future__ import annotations

from dataclasses import dataclass

Numbers = tuple[float | None, ...]


@dataclass(frozen=True)
class ToldEstimate:
    """(K,) estimates of one parameter and their standard errors, over K thresholds."""

    value: Numbers
    std_error: Numbers


@dataclass(frozen=True)
class ToldSweep:
    """Parameters of equation 7 by threshold: I kg·m², Fc N·m, Fv N·m·s/rad. I_band: low and high
    (K,) of what counts as the same inertia; reference_threshold, converged_from: rad/s."""

    thresholds: Numbers
    I: ToldEstimate  # noqa: E741
    Fc: ToldEstimate
    Fv: ToldEstimate
    I_band: tuple[Numbers, Numbers]
    share_of_samples: Numbers
    reference_threshold: float
    converged_from: float

    def of(self, name: str) -> ToldEstimate:
        """``I``, ``Fc`` or ``Fv``."""
        return {"I": self.I, "Fc": self.Fc, "Fv": self.Fv}[name]


@dataclass(frozen=True)
class ToldMap:
    """Friction by speed: (m,) rad/s and N·m; edges (m+1,) rad/s."""

    speed: Numbers
    forward: Numbers
    backward: Numbers
    level: Numbers
    std_error: Numbers
    edges: Numbers


@dataclass(frozen=True)
class ToldBoundary:
    """``BoundaryVelocity`` of one joint (from 1), with what it was read from."""

    joint: int
    threshold: float
    std_error: float
    interval: tuple[float, float]
    decided_by: str
    finest: float
    from_inertia: float
    from_map: float
    gravity: str
    sentence: str
    sweep: ToldSweep
    friction_map: ToldMap
