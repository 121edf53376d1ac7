"""How much torque an export leaves behind, on motion that the arm has made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.effects import Context
from pa10d.export.endings import Format
from pa10d.export.mjcf import PROPERTIES
from pa10d.export.python_module import writable
from pa10d.export.straight_line import traceable
from pa10d.export.tabulated import Tabulated
from pa10d.export.urdf import CARRIED
from pa10d.model import Term, TorqueModel

Array = NDArray[np.float64]

HELD: Mapping[Format, Callable[[TorqueModel], tuple[Term, ...]]] = {
    "urdf": lambda model: tuple(t for t in model.terms if t.effect.joint_property in CARRIED),
    "mjcf": lambda model: tuple(t for t in model.terms if t.effect.joint_property in PROPERTIES),
    "sdf": lambda model: tuple(t for t in model.terms if t.effect.joint_property in CARRIED),
    "python": lambda model: writable(model),
    "c": lambda model: traceable(model)[0].terms,
    "matlab": lambda model: traceable(model)[0].terms,
    "json": lambda model: model.terms,
    "ros2_control": lambda model: traceable(model)[0].terms,
    "tables": lambda model: traceable(model)[0].terms,
}
"""The effects that a format holds."""

NOTHING = 1e-6  # N·m
FORGETFUL: tuple[Format, ...] = ("c", "matlab", "ros2_control")  # each call stands for itself
RESTING: tuple[Format, ...] = ("tables",)  # held only at rest, and by each joint's own speed


@dataclass(frozen=True)
class Loss:
    """rms (n,) N·m (N) between the model and what the export holds of it, on these runs."""

    runs: tuple[str, ...]
    rms: Array
    sentence: str


def loss(model: TorqueModel, format: Format, motions: Mapping[str, Context]) -> Loss | None:
    """None where everything is held, or there is no motion to say it by. What tables round and
    average is not in it: each tells its own error."""
    held = HELD[format](model)
    forgets = format in FORGETFUL and any(t.effect.remembers for t in held)
    whole = len(held) == len(model.terms) and not forgets and format not in RESTING
    if not motions or whole:
        return None
    deliver = _delivery(replace(model, terms=held), format)
    squares, count = np.zeros(model.robot.n), 0
    for seen in motions.values():
        squares += np.sum((model.predict(seen) - deliver(seen)) ** 2, axis=0)
        count += len(seen.q)
    rms = np.sqrt(squares / count)
    beside = ", beside what each table is off by" if format in RESTING else ""
    return Loss(tuple(motions), rms, _sentence(model, tuple(motions), rms) + beside)


def _delivery(kept: TorqueModel, format: Format) -> Callable[[Context], Array]:
    """What the export makes of a motion."""
    if format in RESTING:
        tabulated = Tabulated(kept)
        return lambda seen: tabulated.torque(seen.q, seen.dq)
    forgetful = format in FORGETFUL
    return lambda seen: kept.predict(replace(seen, apart=seen.apart or forgetful))


def _sentence(model: TorqueModel, runs: tuple[str, ...], rms: Array) -> str:
    """Joint by joint, those that lose something."""
    robot, where = model.robot, ", ".join(runs)
    told = [
        f"{robot.joint_names[j]} {rms[j]:.2g} {robot.torque_unit(j)}"
        for j in map(int, np.flatnonzero(rms > NOTHING))
    ]
    if not told:
        return f"what it does not hold amounts to nothing on {where}"
    return f"what it does not hold amounts to {', '.join(told)} (RMS on {where})"
