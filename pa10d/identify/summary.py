"""The few figures of a fit that clients rely on."""

from __future__ import annotations

from dataclasses import dataclass

from pa10d.model import TorqueModel


@dataclass(frozen=True)
class FitSummary:
    """As INTERFACES has it, ``identify``. id: the name until a store gives one; rms: (n,) N·m on
    the model's own runs; condition_number: None where nobody knows it."""

    id: str
    name: str
    base_parameters: int
    inertial_base_parameters: int
    condition_number: float | None
    cutoff_hz: float
    rms: list[float]
    feasible: bool
    warnings: list[str]


def summary(model: TorqueModel) -> FitSummary:
    """Of a fitted model."""
    textbook = sum(len(t.coefficients) for t in model.terms if t.effect.question == "textbook")
    return FitSummary(
        id=model.name,
        name=model.name,
        base_parameters=len(model.h) + textbook,
        inertial_base_parameters=len(model.h),
        condition_number=model.notes.condition_number,
        cutoff_hz=float(model.cutoff),
        rms=[float(v) for v in model.noise],
        feasible=bool(model.feasible),
        warnings=list(model.notes.warnings),
    )
