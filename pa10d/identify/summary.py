"""The few figures of a fit that clients rely on."""

from __future__ import annotations

from typing import Any

from pa10d.model import TorqueModel


def summary(model: TorqueModel) -> dict[str, Any]:
    """JSON-ready: see INTERFACES, ``identify``. ``id`` is the name until a store gives one."""
    textbook = sum(len(t.coefficients) for t in model.terms if t.effect.question == "textbook")
    return {
        "id": model.name,
        "name": model.name,
        "base_parameters": len(model.h) + textbook,
        "inertial_base_parameters": len(model.h),
        "condition_number": model.notes.get("condition_number"),
        "cutoff_hz": float(model.cutoff),
        "rms": [float(v) for v in model.noise],
        "feasible": bool(model.feasible),
        "warnings": list(model.notes.get("warnings", [])),
    }
