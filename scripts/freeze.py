#!/usr/bin/env python3
"""Findings, parameters, errors and predictions of fixed data, kept and compared to 1e-9.

    freeze.py before.json                     before a change that is to change nothing
    freeze.py after.json --against before.json

Simulated arms with one hidden effect and with none, sample sets and a real robot from beside the
project where they are there. Numbers of two machines differ: compare on one.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bench_real
import numpy as np

from backends.virtual.datasets import figures_of, make_runs, random_effect
from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import robot_from_profile, robot_from_urdf
from pa10d.identify import identify
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel
from pa10d.profile import load_profile
from pa10d.regression.equation import prepare
from pa10d.store.csv_import import read_csv

SAME = 1e-9
HIDDEN = (
    "none", "stribeck", "load_friction", "position_friction", "torque_ripple", "contact",
    "presliding_hysteresis", "thermal_friction", "backlash", "joint_elasticity", "payload",
)  # fmt: skip
SAMPLES = ("s01", "s02", "s03", "s04")
ROBOTS = ("kuka_lwr4",)
SECONDS = 20.0


def main() -> None:
    """Freeze, and compare where there is something to compare with."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--against", type=Path, help="what an earlier call wrote")
    parser.add_argument("--only", nargs="+", metavar="SET", help="fewer sets")
    args = parser.parse_args()
    args.out.write_text(json.dumps(frozen(args.only), indent=1), encoding="utf-8")
    if args.against is not None:
        before, after = (json.loads(p.read_text()) for p in (args.against, args.out))
        before = {name: before.get(name) for name in after}
        changed = list(differences(before, after))
        print("\n".join(changed) or f"the same to {SAME:g}")
        raise SystemExit(bool(changed))


def frozen(only: list[str] | None = None) -> dict[str, Any]:
    """Set -> what came out of it."""
    cases: dict[str, Callable[[], dict[str, Any]]] = {
        name: lambda name=name: simulated(name) for name in HIDDEN
    }
    folder = bench_real.DATA / "samples"
    if folder.is_dir():
        cases |= {name: lambda name=name: sample(folder, name) for name in SAMPLES}
        cases |= {name: lambda name=name: real(name) for name in ROBOTS}
    return {name: case() for name, case in cases.items() if only is None or name in only}


def simulated(name: str) -> dict[str, Any]:
    """A virtual arm with one effect of random size, or none."""
    rng = np.random.default_rng([5, sum(name.encode())])
    effects = [] if name == "none" else [random_effect(rng, name, figures_of("pa10-sim"))]
    changed = name == "payload"
    kinds = ("train_a", "train_b", "valid_a", "valid_b", *(("ref_a", "ref_b") * changed))
    runs, _ = make_runs(5, effects, kinds=kinds, seconds=SECONDS)
    robot = robot_from_profile(load_profile("pa10-sim"))
    return answer(robot, runs, changed)


def sample(folder: Path, name: str) -> dict[str, Any]:
    """A set of another simulator."""
    robot = robot_from_urdf(folder / "robot.urdf")
    files = {f.name.split(".")[0]: f for f in (folder / name).glob("*.csv*")}
    runs = {key: recording(file, robot.n) for key, file in files.items()}
    return answer(robot, runs, "ref_a" in runs)


def real(name: str) -> dict[str, Any]:
    """A real robot's recordings."""
    case = bench_real.case(name)
    found = diagnose(case.identify(), case.train, [case.valid])
    return told(found, case.valid)


def recording(file: Path, joints: int) -> Recording:
    """One CSV file."""
    found = read_csv(file, joints, "sample")
    return Recording(file.name, found.timing.grid, found.samples.q, found.samples.tau)


def answer(robot: Any, runs: dict[str, Recording], changed: bool) -> dict[str, Any]:
    """What is missing; changed: what changed since the reference runs."""
    fit, held = ([runs[f"{kind}_{part}"] for part in "ab"] for kind in ("train", "valid"))
    before = [runs["ref_a"], runs["ref_b"]] if changed else fit
    model = identify(before, robot, name="m0")
    return told(diagnose(model, fit, held, frozen=changed), held[0])


def told(found: Any, held: Recording) -> dict[str, Any]:
    """All that a person is told, and the torque of the last version on held-out motion."""
    last = found.versions[-1]
    return {
        "verdict": found.verdict,
        "rms": list(map(float, found.rms)),
        "unexplained": [[u.joint, list(u.variables)] for u in found.unexplained],
        "findings": [
            {
                "term": f.term.label,
                "parameters": {k: [v.value, v.std_error] for k, v in f.parameters.items()},
                "p_value": f.p_value,
                "rms_before": list(map(float, f.rms_before)),
                "rms_after": list(map(float, f.rms_after)),
                "confounded_with": [[c.effect, list(c.joints)] for c in f.confounded_with],
                "sentence": f.sentence,
            }
            for f in found.findings
        ],
        "h": list(map(float, last.h)),
        "covariance": float(np.sum(np.abs(last.covariance))),
        "torque": predicted(last, held).tolist(),
    }


def predicted(model: TorqueModel, held: Recording) -> Any:
    """(K, n) N·m: every hundredth sample."""
    return model.predict(prepare(held, model.robot, model.cutoff).context)[::100]


def differences(before: Any, after: Any, where: str = "") -> Iterator[str]:
    """One line per value that is not the same."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in before.keys() | after.keys():
            yield from differences(before.get(key), after.get(key), f"{where}/{key}")
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for k, (one, other) in enumerate(zip(before, after, strict=True)):
            yield from differences(one, other, f"{where}/{k}")
    elif isinstance(before, float) and isinstance(after, float):
        if not np.isclose(before, after, rtol=SAME, atol=SAME, equal_nan=True):
            yield f"{where}: {before!r} became {after!r}"
    elif before != after:
        yield f"{where}: {before!r} became {after!r}"


if __name__ == "__main__":
    main()
