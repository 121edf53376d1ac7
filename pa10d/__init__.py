"""Torque models of robot arms from recordings: where they fail, and which effect is missing.

    import pa10d

    robot = pa10d.load_robot("robot.urdf")            # or a profile
    train = pa10d.load_run("train.csv", robot)
    valid = pa10d.load_run("valid.csv", robot)
    model = pa10d.identify(robot, [train])            # rigid bodies + friction, standard errors
    pa10d.compare(model, [valid])                     # where does it fail?
    found = pa10d.diagnose(model, fit=[train], validate=[valid])     # which effect is missing?
    better = pa10d.improve(model, fit=[train], validate=[valid])     # all of it, step by step
    better.model.torque(q, dq, ddq)                   # (N, n) N·m

From files: load_robot, load_run, load_model. Questions: identify, compare, diagnose; what answers
them: add, improve; the library: effects. To files: save_model, export. ``help(pa10d.identify)`` and
so on say what each takes; Robot, Run, Model, Comparison, Diagnosis, Finding and Improvement what
each holds.

Joints count from 1; SI units; torque at the joint side. Values compare by content and cannot be
changed; in a notebook they show their plots. Wrong input raises ``UserError`` with one line: what,
where, what was expected. Nothing here needs a daemon or touches a data folder.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from pa10d.common.version import __version__ as __version__

if TYPE_CHECKING:
    from pa10d.common.errors import Cancelled, UserError
    from pa10d.face.answers import Comparison, Diagnosis, Finding, Improvement
    from pa10d.face.effects import effects
    from pa10d.face.model import Model, export, load_model, save_model
    from pa10d.face.questions import compare, diagnose, identify
    from pa10d.face.robot import Robot, load_robot
    from pa10d.face.run import Run, load_run
    from pa10d.face.versions import add, improve

_ROOMS = ("compare", "diagnose", "effects", "export", "identify")  # which answer when called
_HOME = {
    "pa10d.common.errors": ("Cancelled", "UserError"),
    "pa10d.face.answers": ("Comparison", "Diagnosis", "Finding", "Improvement"),
    "pa10d.face.model": ("Model", "load_model", "save_model"),
    "pa10d.face.robot": ("Robot", "load_robot"),
    "pa10d.face.run": ("Run", "load_run"),
    "pa10d.face.versions": ("add", "improve"),
}
_MODULE = {name: module for module, names in _HOME.items() for name in names}

__all__ = [
    "Cancelled",
    "Comparison",
    "Diagnosis",
    "Finding",
    "Improvement",
    "Model",
    "Robot",
    "Run",
    "UserError",
    "add",
    "compare",
    "diagnose",
    "effects",
    "export",
    "identify",
    "improve",
    "load_model",
    "load_robot",
    "load_run",
    "save_model",
]


def __getattr__(name: str) -> Any:
    """Loaded when first asked for: commands and processes start in a fraction of a second."""
    if name in _ROOMS:
        return importlib.import_module(f"pa10d.{name}")
    if name not in _MODULE:
        raise AttributeError(f"module 'pa10d' has no attribute {name!r}")
    return getattr(importlib.import_module(_MODULE[name]), name)


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
