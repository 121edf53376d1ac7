"""Values as a notebook shows them: what there is to see of each, on one page of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.common.version import __version__
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.dynamics import Robot
from pa10d.figures.friction_curves import friction_curves
from pa10d.figures.held_out import HeldOut
from pa10d.figures.of_diagnosis import diagnosis_figures
from pa10d.figures.recorded import recorded
from pa10d.figures.staircase import Stair, staircase
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel
from pa10d.report.blocks import Block, Lines, Plot, Section, Table
from pa10d.report.diagnosis_page import diagnosis_page
from pa10d.report.finding_section import Asked, finding_section
from pa10d.report.model_page import model_sections, robot_section
from pa10d.report.page import page

FOOTER = f"pa10d {__version__}. SI units, torque at the joint side, joints numbered from 1."


def robot_page(robot: Robot) -> str:
    """Joints and their limits."""
    return page(robot.name, f"{robot.n} joints", [robot_section(robot)], FOOTER)


def run_page(recording: Recording, remarks: Sequence[str]) -> str:
    """Positions and torques over time, the extent of both, and what is to be known of it."""
    names = tuple(f"joint {j + 1}" for j in range(recording.q.shape[1]))
    head = ["joint", "least angle", "greatest", "least torque", "greatest"]
    rows = [
        [str(j + 1), *(f"{v:.4g}" for v in _extent(recording.q[:, j], recording.tau[:, j]))]
        for j in range(recording.q.shape[1])
    ]
    blocks: list[Block] = [
        Plot("Positions and torques", recorded(recording, names)),
        Table(head, rows),
    ]
    seconds = float(recording.t[-1] - recording.t[0])
    return page(
        recording.name,
        f"{seconds:.4g} s at {recording.rate:.6g} Hz, {len(names)} joints",
        [*blocks, *([Lines([("Note:", remark) for remark in remarks])] if remarks else [])],
        FOOTER,
    )


def _extent(*channels: np.ndarray) -> list[float]:
    return [float(edge) for values in channels for edge in (np.min(values), np.max(values))]


def model_sheet(model: TorqueModel) -> str:
    """All that the model says of itself, without the runs that it was fitted to."""
    friction = Section(
        "Friction", [Plot("Friction of every joint by its speed", friction_curves(model))]
    )
    return page(
        model.name,
        f"{model.robot.name}, {model.robot.n} joints · {model.change}",
        [friction, *model_sections(model)],
        FOOTER,
    )


def finding_page(found: Diagnosis, k: int, seen: HeldOut, asked: Asked) -> str:
    """One finding of a diagnosis."""
    drawn = diagnosis_figures(found, seen)["findings"][k]
    return page(
        found.findings[k].term.effect.title,
        f"{found.model.robot.name} · judged on {found.judged_on}",
        [finding_section(found, k, drawn, asked)],
        FOOTER,
    )


def improvement_page(
    found: Diagnosis, names: Sequence[str], promised: np.ndarray, seen: HeldOut, asked: Asked
) -> str:
    """The way from the first version to the last, before all that the diagnosis says.

    names: of the versions, the given model first; promised: (n,) N·m by the search
    """
    robot = found.model.robot
    stages = found.stages
    shown = (names[0], f"{names[0]}, {found.begins}", *names[1:])
    head = ["joint", *shown, "promised", "noise floor", "unit"]
    rows = [
        [
            f"{j + 1} {joint}", *(f"{error[j]:.4g}" for _, error in stages), f"{promised[j]:.4g}",
            f"{found.noise_floor[j]:.4g}" if np.isfinite(found.noise_floor[j]) else "unknown",
            robot.torque_unit(j),
        ]
        for j, joint in enumerate(robot.joint_names)
    ]  # fmt: skip
    steps = [
        Stair(name, change, error) for name, (change, error) in zip(shown, stages, strict=True)
    ]
    blocks: list[Block] = [Table(head, rows)]
    if found.findings:
        stairs = staircase(steps, robot.joint_names, found.noise_floor)
        blocks.insert(0, Plot("Error of every version", stairs))
    return diagnosis_page(found, seen, asked, (Section("The improvement", blocks),))
