"""Arms and daemons that the page is tried on."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import yaml

from pa10d.profile import find_profile

HIDDEN = {"effect": "stribeck", "joint": 3, "Fs": 4.0, "vs": 0.1}
"""In the third of three joints, which is the fourth of the whole arm."""
RATE = 250  # Hz: half the cycles to compute, and what a page shows is the same


def small_arm(folder: Path, hidden: dict = HIDDEN) -> Path:
    """Shoulder and elbow of the simulated arm, and what they hide."""
    base = find_profile("pa10-sim")
    profile = yaml.safe_load(base.read_text())
    chosen = [0, 1, 3]
    profile["urdf"] = str(base.parent / profile["urdf"])
    for place in (profile, profile["limits"]):
        for key in ("joints", "drives", "velocity", "acceleration", "torque"):
            if key in place:
                place[key] = [place[key][j] for j in chosen]
    profile["control"]["rate"] = RATE
    profile["simulation"]["options"] = {
        "effects": [hidden], "dynamics": {"spread": 0.2, "seed": 5}, "seed": 3
    }  # fmt: skip
    path = folder / "small.yaml"
    path.write_text(yaml.safe_dump(profile))
    return path


@contextlib.contextmanager
def served(data: Path, channel: str, *options: str) -> Iterator[str]:
    """``pa10d serve`` without an arm: its address."""
    with _serving(data, channel, "--no-sim", *options) as url:
        yield url


@contextlib.contextmanager
def served_arm(data: Path, channel: str, *options: str) -> Iterator[str]:
    """``pa10d serve`` with a virtual arm in simulated time: its address."""
    with _serving(data, channel, "--clock", "simulated", *options) as url:
        yield url


@contextlib.contextmanager
def _serving(data: Path, channel: str, *options: str) -> Iterator[str]:
    command = [sys.executable, "-m", "pa10d", "--data", str(data), "--json", "serve"]
    command += ["--port", "0", "--channel", channel, *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        yield json.loads(process.stdout.readline())["url"]
    finally:
        process.terminate()
        process.wait(30)
        process.stdout.close()


def children_of(pid: int, module: str) -> list[int]:
    """Processes that this one has started with ``python -m module``."""
    asked = subprocess.run(["pgrep", "-P", str(pid), "-f", module], capture_output=True, text=True)
    return [int(one) for one in asked.stdout.split()]
