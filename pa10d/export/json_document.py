"""A model as one JSON document: all there is to know of it, for programs of any language."""

from __future__ import annotations

import json
from dataclasses import asdict

import numpy as np

from pa10d.common.jsonable import JsonObject, plain
from pa10d.dynamics.base import parameter_name
from pa10d.dynamics.robot import PARAMETER_NAMES, Robot
from pa10d.effects import Value
from pa10d.model import TorqueModel

SCHEMA = "pa10d/model/1"


def json_document(model: TorqueModel, about: str) -> tuple[str, list[str]]:
    """The document's text; nothing is left out. SI units, joints numbered from 1."""
    names = model.robot.joint_names
    document = {
        "schema": SCHEMA,
        "name": model.name,
        "about": about,
        "equation": "tau = Y_b(q, dq, ddq)*h_b + sum of effects; rad, m, s, N*m, N at the joint",
        "robot": _robot(model.robot),
        "bodies": _bodies(model.rigid, names),
        "bodies_for_loads": None if model.loads is None else _bodies(model.load_bodies, names),
        "feasible_bodies": None if model.standard is None else _bodies(model.standard, names),
        "base_parameters": _base(model),
        "effects": [_effect(model, k) for k in range(len(model.terms))],
        "covariance": {"of": model.parameter_names(), "rows": model.covariance},
        "fit": {
            "runs": list(model.runs),
            "cutoff_hz": float(model.cutoff),
            "torque_late_by_s": float(model.shift),
            "torque_filter": None if model.channel is None else asdict(model.channel),
            "rms": model.noise,
            "held_out": model.held_out,
            "feasible": bool(model.feasible),
        },
        "lineage": {"parent": model.parent, "change": model.change},
        "notes": model.notes.document(),
    }
    return json.dumps(plain(document), ensure_ascii=False, indent=1, allow_nan=False) + "\n", []


def _robot(robot: Robot) -> JsonObject:
    fields = (
        "parent", "order", "rotation", "translation", "axis", "prismatic", "gravity", "lower",
        "upper", "velocity", "effort", "acceleration",
    )  # fmt: skip
    return {
        "name": robot.name,
        "joints": list(robot.joint_names),
        "frames": "joint j's frame in its parent's (index from 0, -1 the base) at q_j = 0",
        **{field: getattr(robot, field) for field in fields},
        "urdf": robot.urdf,
    }


def _bodies(standard: np.ndarray, names: tuple[str, ...]) -> list[JsonObject]:
    """Mass, first moments and inertia about the origin of each joint's frame."""
    return [
        {"joint": name} | dict(zip(PARAMETER_NAMES, map(float, row), strict=True))
        for name, row in zip(names, standard, strict=True)
    ]


def _base(model: TorqueModel) -> list[JsonObject]:
    rows = zip(model.base.kept, model.base_values, model.base.matrix(), strict=False)
    return [
        {
            "name": parameter_name(int(kept)),
            "value": float(value.value),
            "std_error": float(value.std_error),
            "of_standard": {
                parameter_name(int(k)): float(row[k]) for k in np.flatnonzero(np.abs(row) > 1e-12)
            },
        }
        for kept, value, row in rows
    ]


def _effect(model: TorqueModel, index: int) -> JsonObject:
    term = model.terms[index]
    kind = term.effect
    units = {s.name: s.unit for s in kind.shapes}
    return {
        "effect": term.effect_id,
        "joints": [j + 1 for j in term.joints],
        "over": list(term.over),
        "title": kind.title,
        "equation": kind.equation,
        "acts_on": "the sensor" if kind.sensing else "the arm",
        "remembers": kind.remembers or None,
        "coefficients": {
            name: _told(value) for name, value in model.coefficient_values(index).items()
        },
        "shape": {
            name: {
                "value": float(value),
                "std_error": term.shape_errors.get(name),
                "unit": units.get(name),
            }
            for name, value in term.shape.items()
        },
        "values": {name: _told(value) for name, value in model.term_values(index).items()},
    }


def _told(value: Value) -> JsonObject:
    return {"value": value.value, "std_error": value.std_error, "unit": value.unit}
