"""How much torque an export leaves behind, on motion that the arm has made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import rounded
from pa10d.effects import Context
from pa10d.export.endings import Format
from pa10d.export.mjcf import DRY_LAG, PROPERTIES
from pa10d.export.python_module import writable
from pa10d.export.straight_line import traceable
from pa10d.export.tabulated import Tabulated
from pa10d.export.urdf import CARRIED
from pa10d.measurement.signals import Lowpass
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
DRY: Mapping[Format, float] = {"urdf": 0.0, "sdf": 0.0, "mjcf": DRY_LAG}
"""Formats in which friction turns round at once, where speed and so many s of acceleration pass
zero, and not by a slope."""
RESTING: tuple[Format, ...] = ("tables",)  # held only at rest, and by each joint's own speed


@dataclass(frozen=True)
class Loss:
    """rms (n,) N·m (N) between the model and what the export holds of it, on these runs in the
    band of the model."""

    runs: tuple[str, ...]
    rms: Array
    sentence: str


def loss(model: TorqueModel, format: Format, motions: Mapping[str, Context]) -> Loss | None:
    """None where everything is held, or there is no motion to say it by. What tables round and
    average is not in it: each tells its own error."""
    held = HELD[format](model)
    forgets = format in FORGETFUL and any(t.effect.remembers for t in held)
    whole = len(held) == len(model.terms) and not forgets and format not in RESTING
    if not motions or (whole and format not in DRY):
        return None
    deliver = _delivery(replace(model, terms=held), format)
    squares, count = np.zeros(model.robot.n), 0
    for seen in motions.values():
        missed = model.predict(seen) - deliver(seen)
        missed = _in_band(missed, seen.t, model.cutoff)
        squares += np.sum(missed**2, axis=0)
        count += len(missed)
    rms = np.sqrt(squares / count)
    if whole and not (rms > _floor(model)).any():
        return None
    beside = ", beside what each table is off by" if format in RESTING else ""
    return Loss(tuple(motions), rms, _sentence(model, tuple(motions), rms) + beside)


def _delivery(kept: TorqueModel, format: Format) -> Callable[[Context], Array]:
    """What the export makes of a motion."""
    if format in RESTING:
        tabulated = Tabulated(kept)
        return lambda seen: tabulated.torque(seen.q, seen.dq)
    if format in DRY:
        return lambda seen: _turning_at_once(kept, seen, DRY[format])
    if format in FORGETFUL:
        return lambda seen: kept.predict(replace(seen, apart=True, temperature=None))
    return kept.predict


def _turning_at_once(kept: TorqueModel, seen: Context, lag: float) -> Array:
    """(N, n) with dry friction as formats of bodies know it."""
    dry = [term.effect.joint_property == "friction" for term in kept.terms]
    others = tuple(term for term, rubs in zip(kept.terms, dry, strict=True) if not rubs)
    out = replace(kept, terms=others).predict(seen)
    for term in (term for term, rubs in zip(kept.terms, dry, strict=True) if rubs):
        (j,) = term.joints
        size = term.effect.as_property(term.coefficients, term.shape)
        out[:, j] += size * np.sign(seen.dq[:, j] + lag * seen.ddq[:, j])
    return out


def _in_band(torque: Array, t: Array, cutoff: float) -> Array:
    """(N, n) without what lies above the model's band, where accelerations are noise and rotors
    make torque of it, and without the ends that a filter does not know."""
    rate = (len(t) - 1) / float(t[-1] - t[0])
    if cutoff >= 0.5 * rate:
        return torque
    lowpass = Lowpass(len(t), rate, cutoff)
    ends = min(lowpass.settle, (len(t) - 1) // 2)
    return lowpass(torque)[ends : len(t) - ends]


def _floor(model: TorqueModel) -> Array:
    """(n,) N·m (N) what a motion that was repeated, or else the fit, leaves by chance."""
    known = np.array(model.notes.noise_floor or model.noise, dtype=float)
    return np.where(np.isfinite(known), known, model.noise)


def _sentence(model: TorqueModel, runs: tuple[str, ...], rms: Array) -> str:
    """Joint by joint, those that lose something."""
    robot, where = model.robot, ", ".join(runs)
    told = [
        f"{robot.joint_names[j]} {rounded(rms[j], 2)} {robot.torque_unit(j)}"
        for j in map(int, np.flatnonzero(rms > NOTHING))
    ]
    if not told:
        return f"what it does not hold amounts to nothing on {where}"
    return (
        f"what it does not hold amounts to {', '.join(told)} "
        f"(RMS on {where}, low-pass {model.cutoff:.3g} Hz)"
    )
