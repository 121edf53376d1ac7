"""The report of a comparison."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d import figures
from pa10d.common.version import __version__
from pa10d.common.words import counted, joint_words, times, times_noise
from pa10d.compare import Comparison, RunScores
from pa10d.compare.phrases import brief
from pa10d.figures.staircase import Stair
from pa10d.judgement import MATERIAL
from pa10d.report.blocks import Block, Cards, Lines, Plot, Section, Table, Text
from pa10d.report.near_noise import near_noise
from pa10d.report.page import page

Array = NDArray[np.float64]

OVER_TIME = "Measured, modelled, and what is between them"
OPEN = 3  # joints, worst first, whose sections are open at the start
WHITE = 0.01  # p below which what is left is not white


def compare_page(comparison: Comparison, steps: Sequence[Stair] = ()) -> str:
    """One HTML file; steps: earlier versions and this one, judged on the same runs."""
    model, pooled = comparison.model, comparison.pooled
    runs = ", ".join(run.name for run in comparison.runs)
    blocks = [
        _summary(comparison),
        _failures(comparison),
        *figures_sections(comparison, steps),
        *joint_sections(comparison),
    ]
    return page(
        f"{model.name}: where does it fail?",
        f"{model.robot.name}, {model.robot.n} joints · runs {runs} · both sides low-passed at "
        f"{model.cutoff:g} Hz · worst joint {pooled.worst + 1}",
        blocks,
        f"pa10d {__version__}. SI units, torque at the joint side, joints numbered from 1.",
    )


def summary_sections(comparison: Comparison, steps: Sequence[Stair] = ()) -> list[Section]:
    """What is said of all joints together, but for the list of places."""
    return [_summary(comparison), *figures_sections(comparison, steps)]


def figures_sections(comparison: Comparison, steps: Sequence[Stair] = ()) -> list[Section]:
    """The history, where there is one, and the table."""
    history = [_history(comparison, steps)] if len(steps) > 1 else []
    return [*history, _figures(comparison)]


def joint_sections(comparison: Comparison) -> list[Section]:
    """One section per joint; the worst ones are open."""
    first = set(np.argsort(-np.nan_to_num(comparison.pooled.standing))[:OPEN].tolist())
    return [joint_section(comparison, j, j not in first) for j in range(comparison.model.robot.n)]


def joint_section(
    comparison: Comparison, j: int, folded: bool | None = None, *, over_time: bool = True
) -> Section:
    """Everything about one joint (0-based); over_time: with the torque over time of every run."""
    pooled, robot, texts = comparison.pooled, comparison.model.robot, figures.TEXTS
    floor, unit = float(pooled.noise_floor[j]), figures.units(comparison)[j]
    known = bool(np.isfinite(floor))
    mine = [place for place in pooled.where if place.joint == j]
    drawn = figures.joint_figures(comparison, j)
    order, white = comparison.orders[j], comparison.whiteness[j]
    p = "p < 0.001" if white.p_value < 1e-3 else f"p = {white.p_value:.2g}"
    blocks: list[Block] = [
        Lines(
            [("", place.sentence) for place in mine],
            "No range of any quantity carries significantly more error than its share.",
        ),
        *([Plot(OVER_TIME, drawn["time"], texts["time"].told(known))] if over_time else []),
        Plot("The residual against what it may depend on", drawn["maps"],
             texts["maps"].told(known)),
        Plot("In cycles per revolution, and in hertz", drawn["spectra"], texts["spectra"],
             _line_advice(j, order.lines if order else (), unit)),
        Plot("Its memory", drawn["memory"], texts["memory"],
             f"At the rate that the low-pass leaves, these are {white.samples} samples, worth "
             f"{white.effective:.0f} independent ones: "
             f"{'not white' if white.p_value < WHITE else 'white'} ({p})."),
    ]  # fmt: skip
    name = f"Joint {j + 1}"
    rms = pooled.scores.rms[j]
    mark = f"{robot.joint_names[j]} · RMS {rms:.3g} {unit}, {times_noise(rms, floor)}"
    return Section(name, blocks, mark, folded)


def _summary(comparison: Comparison) -> Section:
    pooled, robot = comparison.pooled, comparison.model.robot
    worst = pooled.worst
    place, share = "nowhere", "no region stands out"
    if pooled.where:
        top = pooled.where[0]
        place, share = f"joint {top.joint + 1}", brief(top.joint, top.what)
    seconds = sum(float(run.seen.t[-1]) for run in comparison.residuals)
    cards = Cards(
        [
            ("worst joint", f"{worst + 1} {robot.joint_names[worst]}",
             f"{times(pooled.standing[worst])} the noise floor" if pooled.by_noise
             else f"{100 * pooled.standing[worst]:.2g} % of its torque's range"),
            ("joints near the noise",
             *near_noise(pooled.scores.rms / pooled.noise_floor, MATERIAL)),
            ("stands out", place, share),
            ("judged on", f"{seconds:.0f} s", counted(len(comparison.runs), "run")),
        ]
    )  # fmt: skip
    warnings = [Lines([("Note:", warning) for warning in comparison.warnings])]
    plot = Plot(
        "Error of each joint, in units of its noise"
        if pooled.by_noise
        else "Error of each joint, as a share of its torque's range",
        figures.overview(pooled, robot.joint_names, figures.units(comparison)),
        figures.TEXTS["overview" if pooled.by_noise else "overview_of_range"],
    )
    return Section("At a glance", [cards, *(warnings if comparison.warnings else []), plot])


def _failures(comparison: Comparison) -> Section:
    pooled = comparison.pooled
    ranked = Lines(
        [("", said) for said in (*(p.sentence for p in pooled.where), *pooled.spread)],
        "No region and no dependence stands out: what is left looks like noise.",
    )
    return Section("Where it fails", [ranked])


def _history(comparison: Comparison, steps: Sequence[Stair]) -> Section:
    joints = comparison.model.robot.joint_names
    figure = figures.staircase(steps, joints, comparison.pooled.noise_floor)
    plot = Plot(
        "Every version on these runs",
        figure,
        figures.staircase_text(comparison.pooled.noise_floor),
    )
    return Section("History", [plot])


def _figures(comparison: Comparison) -> Section:
    names = comparison.model.robot.joint_names
    note = Text(
        f"RMS, largest and noise floor in N·m (N for sliding joints), after the low-pass, "
        f"{comparison.pooled.mask}; "
        f"RMS raw: "
        "unfiltered torque; NRMSE: RMS over the range of the measured torque.", muted=True,
    )  # fmt: skip
    blocks: list[Block] = [
        figures_table(comparison.pooled, names),
        Text(_floor_source(comparison.pooled.floor.methods), muted=True),
        note,
    ]
    if len(comparison.runs) > 1:
        blocks += [
            Section(run.name, [figures_table(run, names)], folded=True, listed=False)
            for run in comparison.runs
        ]
    return Section("Figures", blocks)


def _floor_source(methods: Sequence[str | None]) -> str:
    """``Noise floor from repeated motion (joints 1, 2), not known from these runs (joint 3).``"""
    said = []
    for method in dict.fromkeys(methods):
        where = joint_words(j for j, other in enumerate(methods) if other == method)
        said.append(f"{f'from {method}' if method else 'not known from these runs'} ({where})")
    return f"Noise floor {', '.join(said)}."


def figures_table(entry: RunScores, joints: Sequence[str]) -> Table:
    """The figures of one run, or of all of them."""
    found, floor = entry.scores, entry.noise_floor
    head = ["joint", "RMS", "noise floor", "RMS ÷ noise", "RMS raw", "largest", "NRMSE", "R²"]
    rows = [
        [
            f"{j + 1} {name}", f"{found.rms[j]:.4g}",
            f"{floor[j]:.4g}" if floor[j] > 0 else "not known",
            f"{found.rms[j] / floor[j]:.2f}" if floor[j] > 0 else "–", f"{found.rms_raw[j]:.4g}",
            f"{found.max[j]:.4g}", f"{found.nrmse[j]:.2%}", f"{found.r2[j]:.5f}",
        ]
        for j, name in enumerate(joints)
    ]  # fmt: skip
    return Table(head, rows)


def _line_advice(j: int, lines: Sequence[tuple[float, float]], unit: str) -> str:
    if not lines:
        return ""
    order, size = lines[0]
    return (
        f"A line at {order:.4g} cycles per revolution, {size:.3g} {unit}: suspect torque "
        f"ripple in joint {j + 1} (effect torque_ripple), which a diagnosis tests."
    )
