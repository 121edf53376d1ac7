"""The simulated arm with fewer joints or cycles: what holds of any arm is seen sooner on it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from pa10d.profile import find_profile

HIDDEN = {"effect": "stribeck", "joint": 3, "Fs": 4.0, "vs": 0.1}
"""In the third of three joints, which is the fourth of the whole arm."""
RATE = 250  # Hz: half the cycles to compute, and what a user sees is the same


CHOSEN = (0, 1, 3)  # shoulder and elbow


def joints_of_the_arm(chosen: Sequence[int] = CHOSEN) -> dict[str, Any]:
    """The profile of the simulated arm, but for the other joints."""
    base = find_profile("pa10-sim")
    profile = yaml.safe_load(base.read_text())
    profile["urdf"] = str(base.parent / profile["urdf"])
    for place in (profile, profile["limits"]):
        for key in ("joints", "drives", "velocity", "acceleration", "torque"):
            if key in place:
                place[key] = [place[key][j] for j in chosen]
    return profile


def small_arm(folder: Path, hidden: dict = HIDDEN) -> Path:
    """A profile of shoulder and elbow, and what they hide."""
    profile = joints_of_the_arm()
    profile["control"]["rate"] = RATE
    profile["simulation"]["options"] = {
        "effects": [hidden], "dynamics": {"spread": 0.2, "seed": 5}, "seed": 3
    }  # fmt: skip
    path = folder / "small.yaml"
    path.write_text(yaml.safe_dump(profile))
    return path
