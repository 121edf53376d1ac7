"""Arms of two to seven joints with rough URDFs, drawn by a seed: ``python … foreign_arms.py 0 1``.

Nothing of them is the PA10's: axes, lengths, masses, limits, rate. The URDF's masses and inertias
are wrong by up to three times, each body for itself; some gears give way. As in ``gain_grid``, each
is measured and moved through the starting set.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import yaml

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parents[2])]

from arm_bench import ArmBench, Refused
from gain_grid import RATES, RUBS

from pa10d.common.errors import UserError
from pa10d.control.states import Refused as NotTaken
from pa10d.dynamics import inverse_dynamics, robot_from_profile
from pa10d.profile import load_profile
from pa10d.services.starting_set import STARTING_SET
from pa10d.trajectory.kinds import read_request

WRONG = 3.0  # times too heavy or too light a body of the URDF is, at most
SOFTEST, STIFFEST = 1.2, 60.0  # times gravity's slope, of a gear's spring
MOST_WOUND = (
    0.25  # rad by which a gear gives way under its joint's own limit; harmonic drives do by
)
# a hundredth (1e4 N·m/rad for 100 N·m), series elastic joints by a tenth or two
SPRINGY = 0.35  # of the arms have one
SPARE = 1.6, 4.0  # times gravity's torque, of a torque limit
AXES = np.eye(3)


def drawn(seed: int, folder: Path) -> dict:
    """Profile, rate and plant of one arm; its files lie in ``folder``."""
    rng = np.random.default_rng([1408, seed])
    n, rate = int(rng.integers(2, 8)), float(rng.choice(RATES))
    length = 0.45 * np.cumprod(np.append(rng.uniform(0.5, 1.1), rng.uniform(0.55, 1.0, n - 1)))
    mass = 60.0 * length**1.5 * rng.uniform(0.3, 1.2, n)  # of the true arm, kg
    off = np.exp(rng.uniform(-np.log(WRONG), np.log(WRONG), n))  # true to URDF
    turned = off * np.exp(rng.uniform(-0.4, 0.4, n))
    axes = [2 if rng.random() < 0.5 else 1]
    for _ in range(n - 1):  # a joint rarely turns about the axis before it
        axes.append(int(rng.choice([k for k in range(3) if k != axes[-1] or rng.random() < 0.3])))
    reach = rng.uniform(0.9, 2.6, n)
    urdf = folder / "arm.urdf"
    urdf.write_text(_urdf(length, mass / off, axes, reach))
    speed = np.round(rng.uniform(1.0, 2.5, n) * np.linspace(1.0, 2.0, n), 2)
    document = {
        "urdf": str(urdf),
        "joints": [f"j{k + 1}" for k in range(n)],
        "environment": {"floor": "none"},
        "limits": {
            "velocity": speed.tolist(),
            "acceleration": np.round(3.0 * speed, 2).tolist(),
            "torque": [1.0] * n,
        },
        "drives": [{"node": k + 1, "counts_per_rev": 819200, "gear_ratio": 100,
                    "rated_torque": 0.01} for k in range(n)],
        "can": {"interface": "virtualbus", "channel": f"foreign{seed}"},
        "control": {"rate": rate},
        "simulation": {"plant": "rough_plant:make", "clock": "simulated"},
    }  # fmt: skip
    poses = rng.uniform(-reach, reach, (200, n))
    profile = _loaded(folder, document)
    pull, slope = _gravity(profile, off, poses)
    heaviest = np.diagonal(_masses(profile, off, poses), axis1=1, axis2=2).max(axis=0)
    most = pull + heaviest * 3.0 * speed  # strong enough for its own limit of acceleration
    effort = np.maximum(np.round(most * rng.uniform(*SPARE, n), 2), 1.0)
    document["limits"]["torque"] = effort.tolist()
    for drive, limit in zip(document["drives"], effort, strict=True):
        drive["rated_torque"] = float(limit) / 100.0
    options = {
        "inertia": np.round(turned, 3).tolist(),
        "mass": np.round(off, 3).tolist(),
        "rotor": np.round(np.exp(rng.uniform(-1.1, 1.1, n)), 3).tolist(),
        "friction": np.round(rng.uniform(0.1, RUBS) * rng.uniform(0.7, 1.0, n), 3).tolist(),
        "lag": round(float(rng.uniform(0.0, 2e-3)), 5),
        "seed": seed,
    }
    if rng.random() < SPRINGY:
        j = int(rng.integers(0, n))
        times = np.exp(rng.uniform(np.log(SOFTEST), np.log(STIFFEST)))
        stiffness = max(times * max(slope[j], 0.02 * slope.max()), effort[j] / MOST_WOUND)
        options["springs"] = {j + 1: float(f"{stiffness:.4g}")}
    document["simulation"]["options"] = options
    return {"rate": rate, "profile": _loaded(folder, document), "options": options,
            "slope": slope}  # fmt: skip


def built(seed: int, folder: Path, bandwidth: float | None = None) -> ArmBench:
    """The arm of a seed."""
    asked = drawn(seed, folder)
    return ArmBench(asked["rate"], bandwidth, profile=asked["profile"], **asked["options"])


def _loaded(folder: Path, document: dict):
    path = folder / "arm.yaml"
    path.write_text(yaml.safe_dump(document))
    return load_profile(path)


def _masses(profile, off, poses):
    """(N, n, n) kg·m² of the true links."""
    robot = robot_from_profile(profile)
    still, unit = np.zeros_like(poses), np.eye(robot.n)
    true, weightless = robot.parameters * off[:, None], robot.with_gravity(np.zeros(3))
    rows = [
        inverse_dynamics(weightless, true, poses, still, np.tile(one, (len(poses), 1)))
        for one in unit
    ]
    return np.stack(rows, axis=2)


def _gravity(profile, off, poses):
    """(n,) N·m at most, and N·m/rad by which it pulls away at most, of the true arm."""
    robot = robot_from_profile(profile)
    true = robot.parameters * off[:, None]

    def torque(q):
        return inverse_dynamics(robot, true, q, 0.0 * q, 0.0 * q)

    pull, slope = np.abs(torque(poses)).max(axis=0), np.zeros(robot.n)
    for j in range(robot.n):
        step = 1e-3 * np.eye(robot.n)[j]
        slope[j] = (((torque(poses - step) - torque(poses + step)) / 2e-3)[:, j]).max()
    return pull, slope


def _urdf(length, mass, axes, reach) -> str:
    """A chain; each body a rod along z, its centre a little aside."""
    n = len(length)
    lines = ['<robot name="foreign"><link name="base"/>']
    for k in range(n):
        a, m = length[k], mass[k]
        thick, thin = m * a**2 / 12.0 + m * (0.15 * a) ** 2 / 4.0, m * (0.15 * a) ** 2 / 2.0
        lines.append(
            f'<link name="l{k + 1}"><inertial><origin xyz="{0.1 * a:.5f} {-0.05 * a:.5f} '
            f'{0.45 * a:.5f}"/><mass value="{m:.5f}"/><inertia ixx="{thick:.7f}" ixy="0" ixz="0" '
            f'iyy="{thick:.7f}" iyz="0" izz="{thin:.7f}"/></inertial></link>'
        )
        above = length[k - 1] if k else 0.2
        axis = " ".join(str(int(v)) for v in AXES[axes[k]])
        lines.append(
            f'<joint name="j{k + 1}" type="revolute"><parent link="{f"l{k}" if k else "base"}"/>'
            f'<child link="l{k + 1}"/><origin xyz="0 0 {above:.5f}"/><axis xyz="{axis}"/>'
            f'<limit lower="{-reach[k]:.4f}" upper="{reach[k]:.4f}" effort="1" velocity="1"/>'
            "</joint>"
        )
    return "\n".join([*lines, "</robot>"])


def run(seed: int, words: bool = False) -> dict:
    """One arm through all of it: whole, refused in words, or ended by a fault."""
    began = time.time()
    with tempfile.TemporaryDirectory() as name:
        asked = drawn(seed, Path(name))
        out = {"seed": seed, "n": len(asked["slope"]), "rate": asked["rate"]}
        out |= {"springs": asked["options"].get("springs"), "how": "whole", "at": "", "why": ""}
        try:
            out |= _through(ArmBench(asked["rate"], profile=asked["profile"], **asked["options"]),
                            words)  # fmt: skip
        except (Refused, NotTaken, UserError) as refused:
            out |= {"how": "refused", "why": str(refused), "at": out["at"] or "first_motion"}
    out["seconds"] = round(time.time() - began, 1)
    return out


def _through(arm: ArmBench, words: bool) -> dict:
    fault = arm.first_motion()
    if words:
        print("\n".join([*arm.notes, *arm.known.sentences]))
    if fault is not None:
        return {"how": "FAULT", "at": "first_motion", "why": fault.sentence}
    for number, entry in enumerate(STARTING_SET[1:], 2):
        at = {"at": f"{number} {entry.kind}"}
        request = read_request({"kind": entry.kind, "parameters": entry.parameters})
        try:
            _, fault = arm.run_on(request.build(arm.around))
        except (Refused, NotTaken, UserError) as refused:
            left = isinstance(refused, NotTaken) and refused.command == "enable"  # by a fault
            return {"how": "FAULT" if left else "refused", "why": str(refused), **at}
        if fault is not None:
            return {"how": "FAULT", "why": fault.sentence, **at}
    return {}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seeds", type=int, nargs="+", help="two with --range: from, to")
    parser.add_argument("--range", action="store_true")
    parser.add_argument("--words", action="store_true")
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    found = []
    for seed in range(*asked.seeds) if asked.range else asked.seeds:
        one = run(seed, asked.words)
        found.append(one)
        print(*one.values(), flush=True)
        if asked.json:
            asked.json.write_text(json.dumps(found, indent=1))
    for how in ("whole", "refused", "FAULT"):
        print(f"{how}: {sum(one['how'] == how for one in found)} of {len(found)}")


if __name__ == "__main__":
    main()
