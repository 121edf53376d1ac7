"""What a model can be written as, with which parameters, and what it loses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from pa10d.common.errors import UserError
from pa10d.effects import Context
from pa10d.export.c_header import c_header
from pa10d.export.endings import FORMATS, Files, Format
from pa10d.export.json_document import json_document
from pa10d.export.loss import Loss, loss
from pa10d.export.matlab import matlab_function
from pa10d.export.mjcf import mjcf
from pa10d.export.python_module import python_module
from pa10d.export.ros2_control import ros2_control
from pa10d.export.rotors import rotors_in_bodies
from pa10d.export.sdf import sdf
from pa10d.export.tables import tables
from pa10d.export.urdf import urdf_with_inertia
from pa10d.model import Parameters, TorqueModel
from pa10d.model.impossible import impossible

WRITTEN = {
    "feasible": "feasible parameters: bodies that can exist, friction that brakes",
    "free": "free parameters: the unconstrained fit, which no arm need be able to have",
}

Write = Callable[[TorqueModel, str], tuple[str | Files, list[str]]]
"""The text of a model or the files of a folder, and one line per thing that they cannot carry."""

WRITERS: Mapping[Format, Write] = {
    "urdf": urdf_with_inertia,
    "mjcf": mjcf,
    "sdf": sdf,
    "python": python_module,
    "c": c_header,
    "matlab": matlab_function,
    "json": json_document,
    "ros2_control": ros2_control,
    "tables": tables,
}
BODIES_ONLY: tuple[Format, ...] = ("urdf", "mjcf", "sdf")
"""Formats of bodies, which base parameters alone do not make."""
WITHOUT_ROTORS: tuple[Format, ...] = ("urdf", "sdf")


@dataclass(frozen=True)
class Exported:
    """text: of the one file; files: of a folder, where the format is one; parameters: of which fit;
    not_carried: one line per thing that the format has no place for; warnings: what of a free fit
    no arm can have; loss: what that amounts to, where known."""

    text: str
    format: Format
    parameters: Parameters
    not_carried: tuple[str, ...]
    warnings: tuple[str, ...]
    loss: Loss | None = None
    files: Mapping[str, str] = field(default_factory=dict)


def export(
    model: TorqueModel,
    format: Format,
    parameters: Parameters = "feasible",
    about: str = "",
    motions: Mapping[str, Context] | None = None,
) -> Exported:
    """The model as text; about: where it comes from; motions: run -> motion, by which what a format
    does not hold is told in N·m."""
    if format not in FORMATS:
        raise UserError(f"format {format!r}: expected one of {', '.join(FORMATS)}")
    bodies_only = format in BODIES_ONLY
    if parameters == "free" and bodies_only:
        raise UserError(
            f"format {format}: it holds bodies, which the base parameters of a free fit alone do "
            "not make; expected --parameters feasible"
        )
    if parameters == "feasible" and model.standard is None:
        instead = "" if bodies_only else ", or --parameters free"
        raise UserError(
            f"model {model.name!r} has no feasible standard parameters; expected a model whose "
            f"identification found some{instead}"
        )
    chosen = model.of(parameters)
    if format in WITHOUT_ROTORS:
        chosen = rotors_in_bodies(chosen)
    missed = loss(chosen, format, motions or {})
    about = f"{about or model.name}; {WRITTEN[parameters]}"
    if missed is not None:
        about += f"; {missed.sentence}"
    written, lost = WRITERS[format](chosen, about)
    warnings = impossible(chosen) if parameters == "free" else ()
    text, files = ("", written) if isinstance(written, dict) else (written, {})
    return Exported(text, format, parameters, tuple(lost), warnings, missed, files)
