"""A torque model as the text of its file."""

from __future__ import annotations

import base64
import xml.etree.ElementTree as ET
from dataclasses import asdict, replace

import numpy as np
import yaml
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.dynamics import Robot, robot_from_urdf
from pa10d.dynamics.base import parameter_name
from pa10d.effects import Value
from pa10d.model import TorqueModel
from pa10d.store.model_info import ModelInfo
from pa10d.store.model_schema import FORMAT
from pa10d.store.yaml_style import BlockText, Dumper, Flow, Row, row, simple

Array = NDArray[np.float64]

HEAD = """\
# A torque model: tau = Y_b(q, dq, ddq) * h_b + sum of effects. SI units, torque at the joint side.
# Standard parameters of link j, in the frame of joint j: mass m, first moments mx my mz, inertia
# about the frame's origin Ixx Ixy Iyy Ixz Iyz Izz. 'pa10d model export' makes a URDF or Python.
# std_error: scatter of the data, what the model lacks, and a torque constant known to 5 % or to
# 'torque_gain_error' (a share, per joint); the covariance is without that last part.
"""
ENCODING = "base64 of little-endian float64, lower triangle row by row"


def model_text(model: TorqueModel, info: ModelInfo) -> str:
    """The whole file; floats are written so that reading gives the same bits."""
    document = {
        "pa10d_model": FORMAT,
        "id": info.id,
        "name": info.name,
        "created": info.created,
        "software": info.software,
        "parent": info.parent,
        "parent_name": info.parent_name,
        "change": info.change,
        "fit": {
            "runs": Row(info.runs),
            "cutoff_hz": float(model.cutoff),
            "shift_s": float(model.shift),
            **({} if model.channel is None else {"torque_filter": asdict(model.channel)}),
            "feasible": bool(model.feasible),
            "rms": row(model.noise),
        },
        "noise_floor": None if info.noise_floor is None else row(info.noise_floor),
        "held_out": {run: row(values) for run, values in model.held_out.items()},
        "robot": _robot(model.robot),
        "base_parameters": _base(model),
        "structure": row(model.base.gap),
        "effects": _effects(model),
        "standard_parameters": _standard(model),
        "notes": simple(replace(model.notes, noise_floor=None).document()),
        "covariance": {"encoding": ENCODING, "data": BlockText(_triangle(model.covariance))},
        "urdf": BlockText(tidy(model.robot.urdf)),
    }
    body = yaml.dump(document, Dumper=Dumper, sort_keys=False, allow_unicode=True, width=100)
    return HEAD + str(body)


def tidy(urdf: str) -> str:
    """The URDF with one element a line."""
    root = ET.fromstring(urdf)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _robot(robot: Robot) -> JsonObject:
    plain = robot_from_urdf(robot.urdf, list(robot.joint_names), robot.gravity).parameters
    tool = robot.parameters[-1] - plain[-1]
    entry: JsonObject = {
        "name": robot.name,
        "joints": Row(robot.joint_names),
        "gravity": row(robot.gravity),
        "limits": {
            key: row(getattr(robot, key))
            for key in ("lower", "upper", "velocity", "effort", "acceleration")
        },
    }
    if robot.gain_error is not None:
        entry["torque_gain_error"] = row(robot.gain_error)
    return entry | ({"tool": row(tool)} if np.any(tool) else {})


def _base(model: TorqueModel) -> list[Flow]:
    base, values = model.base, model.base_values
    out = []
    for i, k in enumerate(base.kept):
        name = parameter_name(int(k))
        entry = _value(values[i])
        used = np.flatnonzero(base.relations[i])
        plus = {parameter_name(int(base.dropped[c])): float(base.relations[i, c]) for c in used}
        loads = {} if model.loads is None else {"in_loads": float(model.loads[i])}
        out.append(Flow({"name": name, **entry} | ({"plus": Flow(plus)} if plus else {}) | loads))
    return out


def _effects(model: TorqueModel) -> list[JsonObject]:
    out = []
    for i, term in enumerate(model.terms):
        kind = term.effect
        entry: JsonObject = {
            "effect": term.effect_id,
            "joints": Row(j + 1 for j in term.joints),
            **({"over": Row(term.over)} if term.over else {}),
            "coefficients": {
                name: _value(value) for name, value in model.coefficient_values(i).items()
            },
        }
        if kind.shapes:
            entry["shape"] = {
                s.name: _estimate(term.shape[s.name], term.shape_errors.get(s.name), s.unit)
                for s in kind.shapes_in(term.shape)
            }
        about = {k: float(v) for k, v in term.shape.items() if k not in entry.get("shape", {})}
        if about:
            entry["linear_about"] = Flow(about)
        known = {*entry["coefficients"], *entry.get("shape", {})}
        derived = {k: v for k, v in model.term_values(i).items() if k not in known}
        if derived:
            entry["values"] = {k: _value(v) for k, v in derived.items()}
        out.append(entry)
    return out


def _standard(model: TorqueModel) -> dict[str, Row] | None:
    if model.standard is None:
        return None
    return dict(zip(model.robot.joint_names, map(row, model.standard), strict=True))


def _value(value: Value) -> Flow:
    return _estimate(value.value, value.std_error, value.unit)


def _estimate(value: float, error: float | None, unit: str) -> Flow:
    known = error is not None and np.isfinite(error)
    return Flow(value=float(value), std_error=float(error) if known else None, unit=unit)  # type: ignore[arg-type]


def _triangle(matrix: Array) -> str:
    lower = np.asarray(matrix)[np.tril_indices(len(matrix))].astype("<f8")
    text = base64.b64encode(lower.tobytes()).decode()
    return "".join(text[k : k + 96] + "\n" for k in range(0, len(text), 96))
