"""What a case study finds, step by step; the report draws it, the command prints it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.effects import Value
from pa10d.identify.summary import FitSummary
from pa10d.paper.told import ToldBoundary
from pa10d.paper.variants import Variants
from pa10d.trajectory.excitation.result import ExcitationFigures

Array = NDArray[np.float64]

SETS: tuple[Literal["A"], Literal["B"]] = ("A", "B")
PID, MODEL, WITH_EFFECTS = "pid", "computed_torque", "computed_torque_with_effects"


@dataclass(frozen=True)
class Boundaries:
    """found: per joint; limit (n,) rad/s, the upper end of
    each interval (at least the slowest speed that was resolved): what design and estimation use"""

    found: tuple[ToldBoundary, ...]
    limit: Array

    @property
    def values(self) -> list[float]:
        """rad/s, one per joint; 0 where friction is linear as far down as the data reach."""
        return [one.threshold for one in self.found]


@dataclass(frozen=True)
class Preparation:
    """The exciting motion as it was run, and what averaging and the Fourier fit make of it.

    t (P,) s, q, dq (P, n) one period as designed, tau (P, n) N·m as measured on average
    noise (n,) N·m of a single period, outside (n,) share of acceleration that the series misses
    fourier_rms: RMS on the other trajectory with the fitted motion, and measured_rms with the
    differentiated one, (n,) N·m each
    """

    t: Array
    q: Array
    dq: Array
    tau: Array
    periods: int
    noise: Array
    outside: Array
    trusted: NDArray[np.bool_]
    cutoff: float
    warnings: tuple[str, ...]
    fourier_rms: Array
    measured_rms: Array


@dataclass(frozen=True)
class Reconstruction:
    """Torque of the other trajectory, filtered alike: t (M,) s; measured, set_a, set_b (M, n)
    N·m."""

    t: Array
    measured: Array
    set_a: Array
    set_b: Array


@dataclass(frozen=True)
class Following:
    """One sine experiment: t (N,) s and error (N, n) rad over whole cycles."""

    t: Array
    error: Array

    @property
    def rms(self) -> Array:
        """(n,) rad."""
        return np.asarray(np.sqrt(np.mean(self.error**2, axis=0)))


@dataclass(frozen=True)
class HiddenFriction:
    """What the virtual arm hides in one joint (from 1): Fs N·m by which friction is higher at rest,
    vs rad/s over which that dies away, with the power delta."""

    effect: str
    joint: int
    Fs: float
    vs: float
    delta: float


@dataclass(frozen=True)
class NamedLack:
    """An effect that the diagnosis has named. joints: from 1; rms_before, rms_after: (n,) N·m on
    data that the fit has not seen."""

    effect: str
    joints: tuple[int, ...]
    parameters: Mapping[str, Value]
    rms_before: Array
    rms_after: Array
    p_value: float


@dataclass(frozen=True)
class CaseStudy:
    """Everything.

    excitation: of the exciting trajectory
    slow_rms: of both sets on the sines of 40 s; following: "4s" and "40s", by controller
    findings: what the diagnosis named, answer: the same in words; seconds: of each step
    """

    seed: int
    joints: tuple[str, ...]
    hidden: tuple[HiddenFriction, ...]
    boundaries: Boundaries
    excitation: ExcitationFigures
    preparation: Preparation
    variants: Variants
    reconstruction: Reconstruction
    slow_rms: dict[str, list[float]]
    identified: FitSummary
    following: dict[str, dict[str, Following]]
    findings: tuple[NamedLack, ...]
    answer: str
    models: dict[str, str]
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def rms_set_a(self) -> list[float]:
        """(n,) N·m on the other trajectory, fitted to the samples above the boundary."""
        return [float(v) for v in self.variants.ours("A").rms]

    @property
    def rms_set_b(self) -> list[float]:
        """(n,) N·m on the other trajectory, fitted to all samples."""
        return [float(v) for v in self.variants.ours("B").rms]

    def document(self) -> JsonObject:
        """JSON of ``case-study``, without the report's path."""
        return {
            "inertial_base_parameters": self.identified.inertial_base_parameters,
            "condition_number": self.excitation.condition_number,
            "boundary_velocity": self.boundaries.values,
            "feasible": self.identified.feasible,
            "rms_set_a": self.rms_set_a,
            "rms_set_b": self.rms_set_b,
            "tracking_rms": {
                pace: {how: run.rms.tolist() for how, run in runs.items()}
                for pace, runs in self.following.items()
            },
            "boundary_used": self.boundaries.limit.tolist(),
            "share_of_set_a": self.variants.share_of_samples,
            "rms_above_boundary": {
                name: self.variants.ours(name).rms_above_boundary.tolist() for name in SETS
            },
            "rms_40s": self.slow_rms,
            "answer": self.answer,
            "findings": [
                {
                    "effect": found.effect,
                    "joints": list(found.joints),
                    "parameters": {name: v.document() for name, v in found.parameters.items()},
                    "p_value": found.p_value,
                }
                for found in self.findings
            ],
            "hidden": [asdict(one) for one in self.hidden],
            "models": self.models,
            "seed": self.seed,
            "seconds": self.seconds,
        }
