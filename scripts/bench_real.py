"""Four real robots: identify on their training runs, judge on the validation run, free and
feasible parameters beside each other; then diagnose what is missing, add it, and judge again.

The recordings lie beside the project (``../shared/data``) and are never part of it. ``plain`` is
the validation RMS of a weighted least-squares fit with rigid bodies, Coulomb and viscous friction
and rotor inertia that the data's own README states, ``offset`` what FIGAROH 1.0.2 reached with a
torque offset per joint.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.compare import compare
from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import Robot, robot_from_urdf
from pa10d.identify import identify
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel
from pa10d.model.notes import CutoffNote
from pa10d.store.csv_import import read_csv

Array = NDArray[np.float64]

HIDDEN_IN_BODIES = ("torque_offset", "presliding_hysteresis")
"""What a free fit hides in bodies that cannot exist: an offset in their masses, the spring of
presliding in negative rotor inertia. With both said, feasibility costs nothing (decision 0030)."""

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


@dataclass(frozen=True)
class Given:
    """Cut-off (Hz), number of training runs, and the figures to beat (N·m per joint)."""

    cutoff: float
    train: int
    plain: tuple[float, ...]
    offset: tuple[float, ...]


ROBOTS = {
    "kuka_lwr4": Given(
        6.0,
        1,
        (0.99, 0.69, 0.37, 0.37, 0.76, 0.29, 0.24),
        (0.52, 1.51, 0.27, 0.52, 0.41, 0.27, 0.19),
    ),
    "panda": Given(
        10.0,
        1,
        (0.21, 0.22, 0.17, 0.17, 0.064, 0.070, 0.051),
        (0.146, 0.208, 0.132, 0.162, 0.060, 0.074, 0.053),
    ),
    "ur10": Given(
        8.0, 1, (3.67, 3.42, 2.14, 1.22, 0.834, 1.33), (3.60, 3.55, 2.45, 0.85, 0.79, 1.13)
    ),
    "kr300": Given(10.0, 2, (183, 523, 315, 55, 84, 40), (158, 416, 282, 65, 71, 33)),
}


def load(robot: str, file: str, joints: int) -> Recording:
    """One CSV file as a recording."""
    path = DATA / robot / file
    found = read_csv(path, joints, robot)
    s = found.samples
    return Recording(file.removesuffix(".csv"), found.timing.grid, s.q, s.tau, s.dq)


def _all_valid(robot: str, joints: int) -> list[Recording]:
    """Every validation run: two of one motion show the noise as it is."""
    files = sorted((DATA / robot).glob("valid*.csv*"))
    return [load(robot, file.name, joints) for file in files]


@dataclass(frozen=True)
class Case:
    """One robot's recordings, ready to be fitted and judged."""

    name: str
    robot: Robot
    train: list[Recording]
    valid: Recording

    @property
    def given(self) -> Given:
        """What stands in the data's README."""
        return ROBOTS[self.name]

    def identify(self, *effects: str) -> TorqueModel:
        """The textbook model, and ``effects`` on every joint."""
        return identify(
            self.train, self.robot, name=self.name, cutoff=self.given.cutoff, with_effects=effects
        )

    def rms(self, model: TorqueModel) -> Array:
        """(n,) N·m on the validation run."""
        return compare(model, [self.valid]).pooled.scores.rms


def case(name: str) -> Case:
    """The recordings of one robot."""
    robot = robot_from_urdf(DATA / name / "robot.urdf")
    train = [load(name, f"train{k + 1}.csv", robot.n) for k in range(ROBOTS[name].train)]
    return Case(name, robot, train, load(name, "valid1.csv", robot.n))


def fitted(case: Case) -> dict[str, Any]:
    """Errors of what ``identify`` gives, free and feasible, on motion it has not seen."""
    started = time.perf_counter()
    plain = case.identify()
    seconds = time.perf_counter() - started
    offset, wide = case.identify("torque_offset"), case.identify(*HIDDEN_IN_BODIES)
    models = {
        "rms": plain,
        "rms_feasible": plain.possible(),
        "rms_with_offset": offset,
        "rms_with_offset_feasible": offset.possible(),
        "rms_with_both": wide,
        "rms_with_both_feasible": wide.possible(),
    }
    rms = {key: case.rms(model) for key, model in models.items()}
    given = np.array(case.given.plain)
    return {
        "robot": case.name,
        "cutoff_hz": case.given.cutoff,
        "chosen_cutoff_hz": identify(case.train, case.robot, name=case.name).cutoff,
        "base_parameters": len(plain.covariance),
        "feasible": all(model.feasible for model in (plain, offset, wide)),
        "identify_s": round(seconds, 3),
        "rms_to_beat": list(case.given.plain),
        "figaroh_with_offset": list(case.given.offset),
        **{key: _rounded(found) for key, found in rms.items()},
        "worst_ratio": {key: round(float(np.max(found / given)), 3) for key, found in rms.items()},
    }


def diagnosed(case: Case) -> dict[str, Any]:
    """What the textbook model lacks, and its error once that is added."""
    plain = case.identify()
    # the cut-off is ours to keep here: the figures to beat were taken at it
    asked = replace(plain, notes=replace(plain.notes, cutoff=CutoffNote(plain.cutoff, "user")))
    started = time.perf_counter()
    found = diagnose(asked, case.train, [case.valid])
    seconds = time.perf_counter() - started
    improved = found.versions[-1]
    before, after = case.rms(plain), case.rms(improved)
    possible = case.rms(improved.possible()) if improved.feasible else after * np.nan
    floor = compare(improved, _all_valid(case.name, case.robot.n)).pooled.noise_floor
    gone = np.maximum(before - after, 0.0)
    return {
        "rms_improved": _rounded(after),
        "rms_improved_feasible": _rounded(possible),
        "ratio_to_better_reference": _rounded(
            after / np.minimum(case.given.plain, case.given.offset)
        ),
        "found": [finding.term.label for finding in found.findings],
        "unexplained": [
            f"joint {u.joint + 1}: {', '.join(u.variables)}" for u in found.unexplained
        ],
        "noise_floor": _rounded(floor),
        "share_of_way_to_floor": _rounded(gone / np.maximum(before - floor, 1e-12)),
        "diagnose_s": round(seconds, 1),
    }


def run(robots: str = "") -> dict[str, Any]:
    """robots: names separated by commas; default all."""
    if not DATA.is_dir():
        raise SystemExit(f"bench.py real: no recordings in {DATA}")
    names = [n for n in robots.split(",") if n] or list(ROBOTS)
    return {"robots": [fitted(one) | diagnosed(one) for one in map(case, names)]}


def sentences(figures: dict[str, Any]) -> str:
    lines = []
    for r in figures["robots"]:
        lines.append(
            f"{r['robot']}: {r['cutoff_hz']:g} Hz (its own choice {r['chosen_cutoff_hz']:g} Hz), "
            f"{r['base_parameters']} parameters in {r['identify_s']} s, feasible: {r['feasible']}"
        )
        rows = (
            ("validation RMS, N·m, to beat", "rms_to_beat"),
            ("  FIGAROH with offset", "figaroh_with_offset"),
            ("identify", "rms"),
            ("  feasible", "rms_feasible"),
            ("with torque offset", "rms_with_offset"),
            ("  feasible", "rms_with_offset_feasible"),
            ("with offset and presliding", "rms_with_both"),
            ("  feasible", "rms_with_both_feasible"),
            ("improved", "rms_improved"),
            ("  feasible", "rms_improved_feasible"),
            ("  over the better reference", "ratio_to_better_reference"),
            ("  noise floor", "noise_floor"),
            ("  share of the way to it", "share_of_way_to_floor"),
        )
        for label, key in rows:
            ratio = f"   worst {r['worst_ratio'][key]}" if key in r["worst_ratio"] else ""
            lines.append(f"  {label:28s}" + " ".join(f"{v:8.3g}" for v in r[key]) + ratio)
        lines.append(f"  found in {r['diagnose_s']} s: {'; '.join(r['found']) or 'nothing'}")
        lines += [f"  unexplained: {entry}" for entry in r["unexplained"]]
    return "\n".join(lines)


def _rounded(values: Any) -> list[float]:
    return [float(f"{v:.3g}") for v in values]
