"""The report of a case study: our figures beside the paper's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.common.version import __version__
from pa10d.effects import Value
from pa10d.figures import case_study_texts as texts
from pa10d.figures.of_boundary import convergence, friction_chart
from pa10d.figures.of_case_study import exciting_motion, reconstruction, tracking, tracking_bars
from pa10d.paper import published
from pa10d.paper.results import MODEL, PID, SETS, WITH_EFFECTS, CaseStudy
from pa10d.report.blocks import Block, Cards, Lines, Plot, Section, Table, Text
from pa10d.report.case_study_words import agreements
from pa10d.report.facts import Command, Facts
from pa10d.report.page import page

WAYS = {
    "ols": "least squares (12a)",
    "wls": "weighted (12b)",
    "penalty": "penalty (17), m, I > 0",
    "penalty_physical": "penalty (17), possible bodies",
    "feasible": "weighted, possible bodies (ours)",
}


def case_study_page(found: CaseStudy) -> str:
    """One HTML file that opens offline."""
    blocks: list[Block] = [
        _glance(found),
        Section("Beside the paper: where we agree, where not, and why", [Lines(agreements(found))]),
        _boundary(found),
        _trajectory(found),
        _estimates(found),
        _reconstruction(found),
        _tracking(found, "4s", "Verification: sines of 4 s", "Fig. 4"),
        _tracking(found, "40s", "Verification: sines of 40 s", "Fig. 5"),
        _low_speed(found),
    ]
    return page(
        "Dynamic model identification of the PA10, joints 1-4",
        "The procedure of Vuong & Ang (2009), chapter 3, on a simulated arm over CAN · seed "
        f"{found.seed}",
        blocks,
        f"pa10d {__version__}. SI units, torque at the joint side, joints numbered from 1.",
    )


def _glance(found: CaseStudy) -> Section:
    paces = found.following
    worst = float(np.max(paces["4s"][MODEL].rms / paces["4s"][PID].rms))
    left = float(np.max(paces["40s"][WITH_EFFECTS].rms / paces["40s"][PID].rms))
    cards = Cards(
        [
            ("condition number", f"{found.excitation.condition_number:.1f}",
             f"paper: around {published.CONDITION_NUMBER:g}"),
            ("inertial base parameters", str(found.identified.inertial_base_parameters),
             "every link a possible body" if found.identified.feasible else "not feasible"),
            ("computed torque at 4 s", f"{100 * worst:.0f} %",
             "of the PID's tracking error, worst joint"),
            ("at 40 s, effect added", f"{100 * left:.0f} %",
             "of the PID's tracking error, worst joint"),
        ]
    )  # fmt: skip
    bars = Plot("Tracking error of each controller", tracking_bars(paces), texts.BARS)
    note = Text(
        "The arm is simulated behind CANopen drives; the loop, the experiments and the analysis "
        "are those that hold the real one. Its friction rises towards standstill; how, only the "
        "simulator knew until the end. Our torque noise and the arm's friction are assumed, so "
        "magnitudes in N·m and rad need not be the paper's: the order of things is compared."
    )
    return Section("At a glance", [cards, note, bars])


def _boundary(found: CaseStudy) -> Section:
    ours, rows = found.boundaries, []
    for j, one in enumerate(ours.found):
        low, high = one.interval
        rows.append(
            [f"{j + 1} {found.joints[j]}", f"{one.threshold:.3f}", f"± {one.std_error:.3f}",
             f"{low:.3f} … {high:.3f}", f"{ours.limit[j]:.3f}", one.decided_by,
             f"{published.BOUNDARY_VELOCITY[j]:g}"]
        )  # fmt: skip
    head = ["joint", "boundary, rad/s", "standard error", "90 % interval", "used", "decided by",
            "paper's"]  # fmt: skip
    named = {f"joint {j + 1}": convergence(one) for j, one in enumerate(ours.found)}
    maps = {f"joint {j + 1}": friction_chart(one) for j, one in enumerate(ours.found)}
    return Section(
        "Boundary velocity",
        [
            Table(head, rows),
            Lines([("", one.sentence) for one in ours.found]),
            Text(
                "Position is commanded, not torque: it stays where it is safe. The upper end of "
                "the interval is what the design and set A use.", muted=True,
            ),
            Plot("Convergence (the paper's Fig. 1a)", named, texts.CONVERGENCE),
            Plot("Friction map (the paper's Fig. 1b)", maps, texts.FRICTION_MAP),
        ],
        mark="paper: 2.2, Table 1",
    )  # fmt: skip


def _trajectory(found: CaseStudy) -> Section:
    about, before = found.excitation, found.preparation
    facts = Facts(
        [
            ("Condition number", f"{about.condition_number:.1f} over all samples, "
             f"{about.condition_number_above_boundary:.1f} over those above the boundary, "
             f"{about.condition_number_scaled:.1f} with columns of unit norm"),
            ("Evenness", f"the joints' own parameters have standard errors within a factor of "
             f"{about.evenness:.1f}"),
            ("Averaging", f"{before.periods} periods; noise of one period "
             f"{_numbers(before.noise)} N·m, of the mean {before.periods ** -0.5:.2f} times that"),
            ("Fourier fit of the motion (15)", _fourier(found)),
            ("Cut-off", f"{before.cutoff:g} Hz on both sides, from the highest harmonic"),
        ]
    )  # fmt: skip
    return Section(
        "Exciting trajectory and pre-processing",
        [
            Plot("The trajectory", exciting_motion(before, found.boundaries.limit.tolist()),
                 texts.EXCITING),
            facts,
            Lines([("Note:", warning) for warning in before.warnings]),
        ],
        mark="paper: 2.3",
    )  # fmt: skip


def _fourier(found: CaseStudy) -> str:
    before = found.preparation
    missed = ", ".join(f"{100 * v:.0f} %" for v in before.outside)
    verdict = "it could be used" if before.trusted.all() else "it is not used on every joint"
    return (
        f"the series misses {missed} of the joints' acceleration, so {verdict}. Fitted with the "
        f"series' motion, the other trajectory is missed by {_numbers(before.fourier_rms)} N·m; "
        f"with the measured motion differentiated, by {_numbers(before.measured_rms)} N·m"
    )


def _estimates(found: CaseStudy) -> Section:
    variants = found.variants
    head = ["set and way", *(f"joint {j + 1}" for j in range(len(found.joints))),
            "possible bodies", "ms"]  # fmt: skip
    rows = []
    for name in "AB":
        for key, words in WAYS.items():
            way = variants.sets[name].ways[key]
            said = {None: "not asked", True: "yes", False: "no"}[way.feasible]
            rows.append([f"{name}, {words}", *(f"{v:.3f}" for v in way.rms), said,
                         f"{1e3 * way.seconds:.0f}"])  # fmt: skip
    shares = ", ".join(f"{100 * v:.0f} %" for v in variants.share_of_samples)
    return Section(
        "Estimates side by side",
        [
            Text(
                f"Set A: rows in which the joint is faster than its boundary ({shares} of joints 1 "
                f"to {len(found.joints)}); set B: all rows. RMS error in N·m on the other "
                "trajectory, all its samples."
            ),
            Table(head, rows),
            Text(
                "Possible bodies: every link's pseudo-inertia is positive definite, so some "
                "distribution of positive mass has these parameters.", muted=True,
            ),
        ],
        mark="paper: 2.4, eq. 12, 17",
    )  # fmt: skip


def _reconstruction(found: CaseStudy) -> Section:
    a, b = (found.variants.ours(name).rms_above_boundary for name in SETS)
    rows = [
        [f"{j + 1} {name}", f"{found.rms_set_a[j]:.3f}", f"{found.rms_set_b[j]:.3f}",
         f"{a[j]:.3f}", f"{b[j]:.3f}", f"{published.RMS_SET_A[j]:g}", f"{published.RMS_SET_B[j]:g}"]
        for j, name in enumerate(found.joints)
    ]  # fmt: skip
    head = ["joint", "set A", "set B", "A, fast samples", "B, fast samples", "paper's A",
            "paper's B"]  # fmt: skip
    drawn = {
        f"joint {j + 1}": reconstruction(found.reconstruction, j) for j in range(len(found.joints))
    }
    return Section(
        "Torque reconstruction",
        [
            Table(head, rows),
            Text("RMS in N·m on a trajectory of another kind: every joint goes to and fro at "
                 "nearly constant speed, each at its own rate.", muted=True),
            Plot("Measured and reconstructed torque (the paper's Fig. 3)", drawn,
                 texts.RECONSTRUCTION),
        ],
        mark="paper: 3.2.1, Table 3",
    )  # fmt: skip


def _tracking(found: CaseStudy, pace: str, title: str, figure: str) -> Section:
    runs = {how: found.following[pace][how] for how in (PID, MODEL)}
    return Section(
        title,
        [
            _errors(found, pace, (PID, MODEL)),
            Plot(f"Tracking error (the paper's {figure})", tracking(runs), texts.TRACKING),
        ],
        mark="paper: 3.2.2",
    )


def _low_speed(found: CaseStudy) -> Section:
    hidden = ", ".join(
        f"{one.effect} in joint {one.joint} (Fs = {one.Fs} N·m, vs = {one.vs} rad/s)"
        for one in found.hidden
    )
    rows = [
        [finding.effect, ", ".join(map(str, finding.joints)),
         "; ".join(_parameter(name, v) for name, v in finding.parameters.items()),
         f"{finding.rms_before[finding.joints[0] - 1]:.3f}" if finding.joints else "",
         f"{finding.rms_after[finding.joints[0] - 1]:.3f}" if finding.joints else ""]
        for finding in found.findings
    ]  # fmt: skip
    head = ["effect", "joint", "parameters", "N·m before", "N·m after"]
    return Section(
        "The low-speed model that the paper asks for",
        [
            Text(found.answer),
            *([Table(head, rows)] if rows else []),
            Text(f"What the simulator had hidden: {hidden}.", muted=True),
            _errors(found, "40s", (PID, MODEL, WITH_EFFECTS)),
            Plot("Tracking error at 40 s, with the effect in the controller",
                 tracking(found.following["40s"]), texts.TRACKING),
            Command("To load a model into the loop of a running arm:",
                    ["pa10d controller computed_torque --model MODEL"]),
        ],
        mark="paper: conclusions",
    )  # fmt: skip


def _errors(found: CaseStudy, pace: str, laws: Sequence[str]) -> Table:
    runs = found.following[pace]
    names = {PID: "PID", MODEL: "computed torque", WITH_EFFECTS: "with the effect added"}
    head = ["joint", *(f"{names[how]}, mrad" for how in laws),
            *(f"{names[how]} ÷ PID" for how in laws[1:])]  # fmt: skip
    rows = [
        [f"{j + 1} {name}", *(f"{1e3 * runs[how].rms[j]:.3f}" for how in laws),
         *(f"{runs[how].rms[j] / runs[PID].rms[j]:.2f}" for how in laws[1:])]
        for j, name in enumerate(found.joints)
    ]  # fmt: skip
    return Table(head, rows)


def _parameter(name: str, found: Value) -> str:
    return f"{name} = {found.value:.3g} ± {found.std_error:.1g}{found.unit_after}"


def _numbers(values: Sequence[float] | np.ndarray) -> str:
    return ", ".join(f"{v:.2g}" for v in values)
