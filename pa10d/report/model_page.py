"""The report of a model: what a reviewer of an identification asks for, in one file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pa10d.common.version import __version__
from pa10d.common.words import joint_words, listed, percent
from pa10d.compare import Comparison
from pa10d.dynamics import Robot
from pa10d.figures.staircase import Stair
from pa10d.identify import summary
from pa10d.judgement import MASK
from pa10d.model import TorqueModel
from pa10d.model.parameters import ParameterLine, parameter_list
from pa10d.report.blocks import Block, Lines, Section, Table, Text
from pa10d.report.compare_page import figures_sections, joint_sections, summary_sections
from pa10d.report.facts import Facts
from pa10d.report.page import page

UNDETERMINED = "not determined"


@dataclass(frozen=True)
class RunFigures:
    """What a run's motion is like. use: what it was used for; (n,) figures, rad and N·m; speed and
    acceleration: largest, of the low-passed angles."""

    name: str
    id: str
    use: str
    kind: str
    recorded: str
    seconds: float
    rate: float
    q_min: np.ndarray
    q_max: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    torque: np.ndarray


@dataclass(frozen=True)
class Dossier:
    """versions: (name, change, when, software) of the line, the first ancestor first; comparison:
    on runs that it was not fitted to, if there are any; ``seen`` says which."""

    model: TorqueModel
    parameters: Sequence[ParameterLine]
    runs: Sequence[RunFigures]
    versions: Sequence[tuple[str, str, str, str]]
    comparison: Comparison | None
    steps: Sequence[Stair]
    seen: str


def model_page(dossier: Dossier, first: Sequence[Section] = ()) -> str:
    """One HTML file that opens without a network; first: what was found, and what is in doubt."""
    model = dossier.model
    return page(
        f"{model.name}: a torque model of {model.robot.name}",
        f"{model.robot.n} joints · {model.change}",
        [*first, *dossier_sections(dossier)],
        f"pa10d {__version__}. SI units, torque at the joint side, joints numbered from 1.",
    )


def dossier_sections(dossier: Dossier) -> list[Section]:
    """The parts, for this report and for others that hold it."""
    model = dossier.model
    return [
        robot_section(model.robot),
        _runs(dossier),
        _identification(model),
        _parameters(dossier.parameters),
        *_bodies(model),
        *_validation(dossier),
        _history(dossier),
    ]


def model_sections(model: TorqueModel) -> list[Section]:
    """What the model says of itself, wherever its runs are."""
    parts = [_identification(model), _parameters(parameter_list(model)), *_bodies(model)]
    return [*parts, robot_section(model.robot)]


def robot_section(robot: Robot) -> Section:
    """Its joints and their limits."""
    head = ["joint", "least", "most", "speed", "torque", "unit of angle", "unit of torque"]
    rows = [
        [f"{j + 1} {name}", _figure(robot.lower[j]), _figure(robot.upper[j]),
         _figure(robot.velocity[j]), _figure(robot.effort[j]), robot.angle_unit(j),
         robot.torque_unit(j)]
        for j, name in enumerate(robot.joint_names)
    ]  # fmt: skip
    gravity = ", ".join(f"{v:.4g}" for v in robot.gravity)
    facts = Facts([("Robot", robot.name), ("Gravity in the base frame", f"{gravity} m/s²")])
    return Section("The robot", [facts, Table(head, rows)])


def _runs(dossier: Dossier) -> Section:
    blocks: list[Block] = []
    if not dossier.runs:
        blocks.append(Text("Its runs are not in this data folder."))
    else:
        head = ["run", "used to", "motion", "recorded", "s", "Hz", "id"]
        rows = [
            [r.name, r.use, r.kind.replace("_", " ") or "imported", r.recorded, f"{r.seconds:.1f}",
             f"{r.rate:.0f}", r.id]
            for r in dossier.runs
        ]  # fmt: skip
        blocks.append(Table(head, rows))
    for run in dossier.runs:
        head = ["joint", "angle", "largest speed", "largest acceleration", "largest torque"]
        rows = [
            [str(j + 1), f"{run.q_min[j]:.3g} … {run.q_max[j]:.3g}", f"{run.speed[j]:.3g}",
             f"{run.acceleration[j]:.3g}", f"{run.torque[j]:.3g}"]
            for j in range(len(run.speed))
        ]  # fmt: skip
        inner: list[Block] = [Table(head, rows)]
        blocks.append(Section(run.name, inner, run.use, folded=True, listed=False))
    note = "rad, rad/s, rad/s², N·m; speed and acceleration of the low-passed angles."
    return Section("The runs and their motion", [*blocks, Text(note, muted=True)])


def _identification(model: TorqueModel) -> Section:
    found = summary(model)
    condition = found.condition_number
    shift = f"{1e3 * model.shift:.3g} ms, found and taken out" if model.shift else "none found"
    effects = listed(_grouped(model))
    facts = [
        ("Base parameters", f"{found.base_parameters}, {found.inertial_base_parameters} of "
         "them inertial"),
        ("Condition number", "not known" if condition is None else
         f"{condition:.4g} (2-norm, SI units, unweighted; small is good: below 100 is excellent, "
         "above 1000 the motion leaves some parameters weak)"),
        ("Low-pass", f"{model.cutoff:.4g} Hz, zero-phase, on both sides alike"),
        ("Samples", MASK),
        ("Effects in it", effects or "none"),
        ("Delay between angle and torque", shift),
        ("Torque channel", f"{model.channel}; the model passes it, too" if model.channel
         else "no low-pass found"),
        ("Bodies", "can exist (a feasible set is known)" if model.feasible
         else "no set of bodies that can exist is known for it"),
        ("Method", "weighted least squares on base parameters, joints weighted by their noise; "
         "standard errors from the scatter between stretches of the data, and from the torque "
         f"constants, which are known to {percent(model.robot.gain_share(()))} or so"),
    ]  # fmt: skip
    names = model.robot.joint_names
    rms = [[f"{j + 1} {n}", f"{model.noise[j]:.4g}"] for j, n in enumerate(names)]
    warnings = [("", warning) for warning in found.warnings]
    blocks: list[Block] = [
        Facts(facts),
        Table(["joint", f"RMS on its own runs, {model.robot.torque_units()}"], rms),
    ]
    return Section("The identification", [*blocks, *([Lines(warnings)] if warnings else [])])


def _grouped(model: TorqueModel) -> list[str]:
    """``coulomb (joints 1 to 7)``: every effect once, with its joints."""
    where: dict[str, list[tuple[int, ...]]] = {}
    for term in model.terms:
        over = f" over {', '.join(term.over)}" if term.over else ""
        name = f"{term.effect_id.replace('_', ' ')}{over}"
        where.setdefault(name, []).append(tuple(term.joints))
    return [f"{name}{_joints(joints)}" for name, joints in where.items()]


def _joints(joints: Sequence[tuple[int, ...]]) -> str:
    if all(len(own) == 1 for own in joints):
        return f" ({joint_words(own[0] for own in joints)})"
    said = [joint_words(own) for own in joints if own]
    return f" ({', '.join(said)})" if said else ""


def _parameters(parameters: Sequence[ParameterLine]) -> Section:
    rows = []
    for one in parameters:
        known, value, error = one.value.determined, one.value.value, one.value.std_error
        share = abs(error / value) if known and error and value else None
        rows.append(
            [one.name, f"{value:.4g}" if known else UNDETERMINED,
             f"± {error:.2g}" if known and error else "–",
             "–" if share is None else f"{100 * share:.0f} %",
             "–" if one.urdf is None else f"{one.urdf:.4g}",
             "" if one.value.unit == "1" else one.value.unit, ", ".join(one.flags) or "–",
             one.meaning]
        )  # fmt: skip
    head = ["parameter", "value", "standard error", "of value", "URDF", "unit", "flags", "meaning"]
    note = Text(
        "Base parameters are the combinations of bodies' masses, first moments and inertias that "
        "torque can show, in the frames of the joints. Weak: the standard error is above 30 % of "
        "the value.",
        muted=True,
    )
    return Section("Parameters", [Table(head, rows, words=1), note])


def _bodies(model: TorqueModel) -> list[Section]:
    if model.standard is None:
        return []
    head = ["joint", *["m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz"]]
    rows = [
        [f"{j + 1} {name}", *(f"{v:.4g}" for v in model.standard[j])]
        for j, name in enumerate(model.robot.joint_names)
    ]
    said = (
        "kg, kg·m, kg·m² about the joint frame's origin: one set of bodies that can exist, of many "
        "that make the same torque."
    )
    rotors = () if model.notes.feasible is None else model.notes.feasible.rotors
    if any(rotors):
        head.append("rotor")
        rows = [[*row, f"{v:.4g}" if v else "–"] for row, v in zip(rows, rotors, strict=True)]
        said += " Rotor: beside a body where torque shows both in one sum."
    note = Text(said, muted=True)
    return [Section("Bodies that can exist", [Table(head, rows), note], folded=True)]


def _validation(dossier: Dossier) -> list[Section]:
    comparison = dossier.comparison
    if comparison is None:
        return [Section("Validation", [Text("There are no runs here to judge it by.")])]
    names = listed([run.name for run in comparison.runs])
    head = Section("Validation", [Text(f"On {names}, {dossier.seen}.")])
    first, *rest = summary_sections(comparison)
    return [head, first, *rest, *_staircase(dossier), *joint_sections(comparison)]


def _staircase(dossier: Dossier) -> list[Section]:
    """The history on these runs, without the table that stands there already."""
    comparison = dossier.comparison
    if comparison is None or len(dossier.steps) < 2:
        return []
    return figures_sections(comparison, dossier.steps)[:1]


def _history(dossier: Dossier) -> Section:
    rows = [list(version) for version in dossier.versions]
    return Section("Versions", [Table(["model", "change", "made", "by"], rows)])


def _figure(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "–"
