"""A model's parameters as a person and a program want them."""

from __future__ import annotations

from typing import Any

from pa10d.dynamics.base import parameter_name
from pa10d.effects.smooth_map import EXPLAINS_NOTHING
from pa10d.export.endings import ENDINGS
from pa10d.model import TorqueModel
from pa10d.model.impossible import impossible


def model_details(model: TorqueModel) -> dict[str, Any]:
    """``parameters``: base parameters and effects, each with value, standard error, unit and
    meaning; ``standard``: feasible standard parameters per joint, or null; ``impossible``: what
    of the free fit no arm can have, in words; ``delivery``: what the search that it came from
    promised, and what it achieves."""
    sentences = model.base.sentences()
    parameters = [
        {
            "name": parameter_name(int(k)),
            **model.base_values[i].document(),
            "meaning": sentences[i],
        }
        for i, k in enumerate(model.base.kept)
    ]
    for i, term in enumerate(model.terms):
        parameters += [
            {
                "name": f"{term.label}: {name}",
                **value.document(),
                "meaning": EXPLAINS_NOTHING if term.over else term.effect.equation,
            }
            for name, value in model.term_values(i).items()
        ]
    standard = None
    if model.standard is not None:
        names = model.robot.joint_names
        standard = {name: list(row) for name, row in zip(names, model.standard, strict=True)}
    return {
        "parameters": parameters,
        "standard": standard,
        "shift_s": model.shift,
        "torque_units": [model.robot.torque_unit(j) for j in range(model.robot.n)],
        "delivery": model.notes.get("delivery"),
        "formats": ENDINGS,
        "impossible": list(impossible(model)),
    }
