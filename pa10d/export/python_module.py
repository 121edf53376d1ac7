"""A model as a Python module that needs NumPy and nothing else."""

from __future__ import annotations

import inspect
import pprint
from typing import Any

import numpy as np

from pa10d.effects.library.base_tilt import SMALL, rotation
from pa10d.export import runtime
from pa10d.export.words import grouped
from pa10d.model import Term, TorqueModel

HEAD = '''"""Joint torques of {name}: {about}.

Written by pa10d; stands on NumPy alone.

    torque(q, dq, ddq)          one sample, shape (n,), or many, (N, n), in any order
    torque_series(q, dq, ddq)   (N, n), rows at equal steps of one motion: the sign of the velocity
                                is averaged over each step, as it was when the model was fitted

Joints: {joints}
Units: rad (m), rad/s, rad/s², N·m (N), torque at the joint side.
{lost}"""

from __future__ import annotations

import numpy as np

JOINTS = {joints!r}
NOT_CARRIED = {not_carried!r}
MODEL = {model}


def torque(q, dq, ddq):
    """Torque of one sample (n,) or of many independent ones (N, n)."""
    single = np.ndim(q) == 1
    out = predict(MODEL, *(np.atleast_2d(np.asarray(x, dtype=float)) for x in (q, dq, ddq)))
    return out[0] if single else out


def torque_series(q, dq, ddq):
    """Torque (N, n) along one motion."""
    q, dq, ddq = (np.asarray(x, dtype=float) for x in (q, dq, ddq))
    return predict(MODEL, q, dq, ddq, series=True)

'''


def python_module(model: TorqueModel, about: str) -> tuple[str, list[str]]:
    """The module's text, and one line per effect that it cannot carry."""
    carried = [term for term in model.terms if _known(term)]
    missing = [term for term in model.terms if not _known(term)]
    lost = [
        f"{label} not in the export: it has a memory or a time of its own, so that a function of "
        "q, dq and ddq cannot give it"
        for label in grouped([term for term in missing if not term.over])
    ] + [
        f"{term.label} not in the export: a map of what nobody understands stays where its range "
        "is watched"
        for term in missing
        if term.over
    ]
    data = _data(model, carried)
    head = HEAD.format(
        name=model.name,
        about=about,
        joints=list(model.robot.joint_names),
        lost="".join(f"\nNOT CARRIED: {line}" for line in lost) + ("\n" if lost else ""),
        not_carried=[term.label for term in missing],
        model=pprint.pformat(data, width=100, compact=True, sort_dicts=False),
    )
    return head + _runtime_text(), lost


def _known(term: Term) -> bool:
    return term.effect_id in runtime.MECHANICS or term.effect_id in runtime.SENSING


def _runtime_text() -> str:
    """The runtime without its own docstring and imports."""
    source = inspect.getsource(runtime)
    return "\n" + source[source.index("def predict(") :]


def _data(model: TorqueModel, terms: list[Term]) -> dict[str, Any]:
    robot = model.robot
    return {
        "parent": robot.parent.tolist(),
        "order": robot.order.tolist(),
        "rotation": robot.rotation.tolist(),
        "translation": robot.translation.tolist(),
        "axis": robot.axis.tolist(),
        "prismatic": robot.prismatic.tolist(),
        "gravity": robot.gravity.tolist(),
        "rigid": model.rigid.tolist(),
        "terms": [_term(model, term) for term in terms],
    }


def _term(model: TorqueModel, term: Term) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "effect": term.effect_id,
        "joints": list(term.joints),
        "coefficients": [float(c) for c in term.coefficients],
        "shape": {name: float(value) for name, value in term.shape.items()},
    }
    return entry | (_tilt(model, term) if term.effect_id == "base_tilt" else {})


def _tilt(model: TorqueModel, term: Term) -> dict[str, Any]:
    """What the effect works out from the robot: change of gravity per angle, and whether the
    first axis stands upright."""
    robot = model.robot
    turns = []
    for axis, name in ((0, "rx"), (1, "ry")):
        at = term.shape.get(name, 0.0) or SMALL
        turns.append(((rotation(axis, at).T @ robot.gravity - robot.gravity) / at).tolist())
    size = float(np.linalg.norm(robot.gravity))
    first = int(robot.order[0])
    along = abs(float(robot.rotation[first] @ robot.axis[first] @ robot.gravity))
    upright = size > 0 and along > 0.99 * size and not robot.prismatic[first]
    return {"turns": turns, "vertical_first": bool(upright)}
