"""Arms that nobody has seen, drawn by a seed: ``python tests/control/gain_grid.py 0 1 2 …``.

Each is measured and moved through the starting set in simulated time, with the product's own
control; per arm a table says what was found and what is true, which margins the true loop has, and
where and why it ended.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parents[2])]

from arm_bench import ArmBench, Refused

from pa10d.control.gains import BUS_DELAY
from pa10d.control.servo_design import Case, JointGains, LoopTiming, sensitivity
from pa10d.dynamics.mass import mass_matrices
from pa10d.services.starting_set import STARTING_SET
from pa10d.trajectory.kinds import read_request

RATES = (100, 125, 200, 250, 333, 400, 500)
LEAST, MOST = 0.3, 3.0  # of the URDF's inertia
RUBS = 3.0  # of the usual friction, at most
MODE = 3.0, 9.0  # times the default bandwidth
SPRING = 1395.0  # N·m/rad


def drawn(seed: int) -> dict:
    """Rate and plant of one arm."""
    rng = np.random.default_rng([14, seed])
    rate = float(rng.choice(RATES))

    def scale(each: bool):
        size = 7 if each else None
        return np.exp(rng.uniform(np.log(LEAST), np.log(MOST), size))

    each = bool(rng.random() < 0.5)
    options = {
        "inertia": np.round(scale(each), 3).tolist(),
        "rotor": np.round(scale(each), 3).tolist(),
        "mass": np.round(rng.uniform(0.8, 1.2, 7), 3).tolist(),
        "friction": np.round(rng.uniform(0.0, RUBS) * rng.uniform(0.7, 1.0, 7), 3).tolist(),
        "seed": seed,
    }
    if rng.random() < 0.2:
        options["friction"] = 0.0
    kind = rng.choice(["rigid", "spring", "mode"])
    if kind == "spring":
        options["springs"] = {int(rng.integers(1, 5)): SPRING}
    if kind == "mode":
        options["modes"] = {int(rng.integers(1, 8)): round(float(rng.uniform(*MODE)), 2)}
    options["lag"] = round(float(rng.uniform(0.0, 2e-3)), 5)
    return {"rate": rate, **options}


def built(rate: float, modes: dict | None = None, **options) -> ArmBench:
    """modes: joint → times the default bandwidth above which motor and link swing in any pose."""
    if modes:
        options["springs"] = {}
        stiff = ArmBench(rate, **options)
        bandwidth = stiff.profile.control.servo_bandwidth
        poses = np.random.default_rng(0).uniform(-1.5, 1.5, (20, 7))
        for joint, times in modes.items():
            link = max(stiff.plant.mass_at(q)[joint - 1, joint - 1] for q in poses)
            rotor = stiff.plant.rotor[joint - 1]
            both = 1.0 / (1.0 / link + 1.0 / rotor)
            options["springs"][joint] = float((2 * np.pi * times * bandwidth) ** 2 * both)
    return ArmBench(rate, **options)


def run(seed: int, words: bool = True) -> dict:
    """One arm through all of it."""
    began = time.time()
    asked = drawn(seed)
    arm = built(**asked)
    out = {"seed": seed, **asked, "ended": None}
    out["first"] = (fault := arm.first_motion()) and fault.sentence
    if words:
        print(f"\n=== {seed}: {asked}")
        print("\n".join(arm.notes))
    if fault is not None:
        out["ended"] = "first_motion"
    if arm.joints is not None and words:
        table(arm)
    errors = []
    for entry in STARTING_SET[1:] if fault is None else ():
        request = read_request({"kind": entry.kind, "parameters": entry.parameters})
        try:
            rows, fault = arm.run_on(request.build(arm.around))
        except Refused as refused:
            out["ended"], out["why"] = entry.kind, f"REFUSED {refused}"
            break
        errors.append(arm.error(rows))
        if fault is not None:
            out["ended"], out["why"] = entry.kind, fault.sentence
            break
    out["why"] = out.get("why") or out["first"]
    out["notes"] = arm.notes
    if errors:
        out["error"] = np.round(np.max(errors, axis=0), 4).tolist()
    out["farthest"] = round(float(np.nanmax(arm.beyond)), 3)
    out["seconds"] = round(time.time() - began, 1)
    if words:
        print("\n".join(arm.notes[-6:]))
        print("largest error", out.get("error"), "beyond", out["farthest"])
        print("ENDED", out["ended"], out["why"], f"({out['seconds']} s)", flush=True)
    return out


def table(arm: ArmBench) -> None:
    """Found and true, and the sensitivity of the true loop in poses of the arm."""
    figures, gains, plant = arm.joints.figures, arm.joints.gains, arm.plant
    here = np.zeros((1, 7))
    found = figures.rotor + figures.link * np.diagonal(mass_matrices(arm.robot, here)[0])
    true_mass = plant.mass_at(here[0])
    true = np.diagonal(true_mass) + plant.rotor
    poses = np.random.default_rng(3).uniform(-1.5, 1.5, (12, 7))
    span = np.array([np.diagonal(plant.mass_at(q)) + plant.rotor for q in poses])
    free = np.array(
        [1 / np.diagonal(np.linalg.inv(plant.mass_at(q) + np.diag(plant.rotor))) for q in poses]
    )
    stiff = np.full(7, np.inf)
    stiff[plant.bent] = plant.stiffness
    timing = LoopTiming(1 / arm.rate, BUS_DELAY / arm.rate + plant.lag)
    print("joint  J found  true   rotor f/t      C found/true   B found/true   delay  K found/true"
          "       kp    ki    kd   light/usual/heavy sensitivity")  # fmt: skip
    for j in range(7):
        chosen = JointGains(gains.kp[j], gains.ki[j], gains.kd[j], np.nan)
        peaks = []
        for inertia in (free[:, j].min(), true[j], span[:, j].max()):
            case = Case(float(inertia), float(plant.wet[j]), float(plant.rotor[j]), float(stiff[j]))
            peaks.append(sensitivity(chosen, case, timing))
        print(
            f"{j + 1}   {found[j]:8.4f} {true[j]:8.4f} {figures.rotor[j]:7.4f}/{plant.rotor[j]:.4f}"
            f" {figures.coulomb[j]:7.3f}/{plant.dry[j]:.3f} {figures.viscous[j]:7.3f}/"
            f"{plant.wet[j]:.3f} {1e3 * figures.delay[j]:6.2f}ms {figures.stiffness[j]:7.4g}/"
            f"{stiff[j]:.4g}  {gains.kp[j]:8.4g} {gains.ki[j]:8.4g} {gains.kd[j]:8.4g}  "
            + " ".join(f"{p:5.2f}" for p in peaks)
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seeds", type=int, nargs="+", help="two with --range: from, to")
    parser.add_argument("--range", action="store_true")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--quiet", action="store_true", help="one line an arm")
    asked = parser.parse_args()
    seeds = range(*asked.seeds) if asked.range else asked.seeds
    found = []
    for seed in seeds:
        one = run(seed, not asked.quiet)
        if asked.quiet:
            print(seed, one["rate"], one["ended"] or "whole", one["why"] or "", flush=True)
        found.append(one)
        if asked.json:
            asked.json.write_text(json.dumps(found, indent=1))
    whole = sum(one["ended"] is None for one in found)
    print(f"\n{whole} of {len(found)} ran the whole starting set")


if __name__ == "__main__":
    main()
