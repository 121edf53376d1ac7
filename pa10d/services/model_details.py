"""What is to be known of a stored model: its parameters, and what is said beside them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pa10d.common.jsonable import JsonObject
from pa10d.export.endings import ENDINGS, Format
from pa10d.model import Delivery, TorqueModel
from pa10d.model.impossible import impossible
from pa10d.model.parameters import ParameterLine, parameter_list


@dataclass(frozen=True)
class ModelDetails:
    """standard: feasible standard parameters per joint, or None; rotors: kg·m² (kg) per joint that
    go with them where base parameters hold both, zero elsewhere, None where nobody knows; shift: s
    by which torque and angle were apart; torque_filter: in words; delivery: what the search that it
    came from promised, and what it achieves, as the model's file has it; formats: for other
    programs, with their files' endings; warnings: what is to be known of it before it is used, as
    its fit said it; impossible: what of the free fit no arm can have, in words."""

    parameters: list[ParameterLine]
    standard: dict[str, list[float]] | None
    rotors: list[float] | None
    shift: float
    torque_filter: str | None
    torque_units: list[str]
    delivery: Delivery | None
    formats: Mapping[Format, str]
    warnings: list[str]
    impossible: list[str]

    def document(self) -> JsonObject:
        """As JSON."""
        return {
            "parameters": [line.document() for line in self.parameters],
            "standard": self.standard,
            "rotors": self.rotors,
            "shift_s": self.shift,
            "torque_filter": self.torque_filter,
            "torque_units": self.torque_units,
            "delivery": self.delivery and self.delivery.document(),
            "formats": dict(self.formats),
            "warnings": self.warnings,
            "impossible": self.impossible,
        }


def model_details(model: TorqueModel) -> ModelDetails:
    """Everything beside what stands in the list of models."""
    standard, found = None, model.notes.feasible
    if model.standard is not None:
        names = model.robot.joint_names
        standard = {name: list(row) for name, row in zip(names, model.standard, strict=True)}
    return ModelDetails(
        parameters=parameter_list(model),
        standard=standard,
        rotors=list(found.rotors) if found is not None and found.rotors else None,
        shift=model.shift,
        torque_filter=None if model.channel is None else str(model.channel),
        torque_units=[model.robot.torque_unit(j) for j in range(model.robot.n)],
        delivery=model.notes.delivery,
        formats=ENDINGS,
        warnings=list(model.notes.warnings),
        impossible=list(impossible(model)),
    )
