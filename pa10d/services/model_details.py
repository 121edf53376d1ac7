"""A model's parameters as a person and a program want them."""

from __future__ import annotations

from typing import Any

from pa10d.dynamics.base import parameter_name
from pa10d.effects import Value
from pa10d.effects.smooth_map import EXPLAINS_NOTHING
from pa10d.export.endings import ENDINGS
from pa10d.model import TorqueModel
from pa10d.model.impossible import impossible

WEAK = 0.3  # of a value: a standard error above that
ROUNDING = 1e-6
UNCHANGED = 0.9  # of the standard error before the data: they told next to nothing
NEAR = 1e-6  # of a range: as good as at its end


def model_details(model: TorqueModel) -> dict[str, Any]:
    """``parameters``: base parameters and effects, each with value, standard error, unit and
    meaning; ``standard``: feasible standard parameters per joint, or null; ``impossible``: what
    of the free fit no arm can have, in words; ``delivery``: what the search that it came from
    promised, and what it achieves."""
    standard = None
    if model.standard is not None:
        names = model.robot.joint_names
        standard = {name: list(row) for name, row in zip(names, model.standard, strict=True)}
    return {
        "parameters": parameter_list(model),
        "standard": standard,
        "shift_s": model.shift,
        "torque_filter": None if model.channel is None else str(model.channel),
        "torque_units": [model.robot.torque_unit(j) for j in range(model.robot.n)],
        "delivery": model.notes.get("delivery"),
        "formats": ENDINGS,
        "impossible": list(impossible(model)),
    }


def parameter_list(model: TorqueModel) -> list[dict[str, Any]]:
    """One entry per parameter, base parameters first: name, value with its errors, unit, meaning;
    ``urdf``: the same base parameter of the bodies that the URDF has, null for effects;
    ``flags``: what is to be known of the value, in words."""
    sentences, urdf = model.base.sentences(), model.base.of(model.robot.parameters)
    before = (model.notes.get("prior") or {}).get("std_errors") or []
    before = [*before, *[None] * (sum(t.width for t in model.terms) + len(urdf) - len(before))]
    places = iter(before[len(urdf) :])
    found = [
        {
            "name": parameter_name(int(k)),
            **value.document(),
            "meaning": sentences[i],
            "urdf": float(urdf[i]),
            "flags": flags(value, before=before[i]),
        }
        for i, (k, value) in enumerate(zip(model.base.kept, model.base_values, strict=True))
    ]
    for i, term in enumerate(model.terms):
        bounds = {shape.name: (shape.lower, shape.upper) for shape in term.effect.shapes}
        doubts = {c.name: next(places) for c in term.effect.coefficients}
        found += [
            {
                "name": term.named(name),
                **value.document(),
                "meaning": EXPLAINS_NOTHING if term.over else term.effect.equation,
                "urdf": None,
                "flags": flags(value, bounds.get(name), doubts.get(name)),
            }
            for name, value in model.term_values(i).items()
        ]
    return found


def flags(
    value: Value, bounds: tuple[float, float] | None = None, before: float | None = None
) -> list[str]:
    """``not determined``, ``at its bound``, ``weak`` (a standard error above 30 % of the value),
    ``from the prior``: as unsure as before any data.

    before: standard error that the value had then; the torque constants' own is not the data's"""
    said = [] if value.determined else ["not determined"]
    if bounds is not None and min(abs(value.value - bound) for bound in bounds) <= NEAR * (
        bounds[1] - bounds[0]
    ):
        said.append("at its bound")
    error = value.std_error if value.random is None else value.random
    rounding = ROUNDING * value.std_error  # of a difference of squares
    if value.determined and before is not None and error + rounding >= UNCHANGED * before:
        said.append("from the prior")
    elif value.determined and value.std_error > WEAK * abs(value.value):
        said.append("weak")
    return said
