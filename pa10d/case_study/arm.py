"""The arm of the case study: the PA10's first four joints, with friction that is hidden."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import yaml

from backends.virtual.plant.textbook import default_textbook
from pa10d.paper.results import HiddenFriction
from pa10d.profile import Profile, Simulation, load_profile

BASE, NAME = "pa10-sim", "pa10-case-study"
JOINTS = 4
SPREAD = 0.2  # masses within ±20 % of the URDF's, friction and rotors within e^±0.4 of the usual
RISE = (0.3, 0.5)  # of the usual Coulomb friction, by which it is higher at rest
SPEED = (0.1, 0.2)  # rad/s over which that rise dies away
POWER = (1.0, 1.6)


def hidden_friction(
    seed: int, profile: Profile, joints: Sequence[int]
) -> tuple[HiddenFriction, ...]:
    """What the virtual arm hides in these joints (from 1), drawn from the seed: friction that rises
    towards standstill."""
    rng = np.random.default_rng([seed, 9])
    usual = default_textbook(np.array(profile.limits.torque)).coulomb
    drawn = [
        HiddenFriction(
            effect="stribeck",
            joint=j + 1,
            Fs=round(float(rng.uniform(*RISE) * usual[j]), 3),
            vs=round(float(rng.uniform(*SPEED)), 4),
            delta=round(float(rng.uniform(*POWER)), 3),
        )
        for j in range(len(usual))
    ]
    return tuple(one for one in drawn if one.joint in joints)


def write_profile(folder: Path) -> Profile:
    """The profile of the arm, as a file in the folder: pa10-sim with its wrist locked.

    The wrist's brakes hold, and the loop does not know of it.
    """
    base = load_profile(BASE)
    text = base.model_dump(mode="json", exclude={"path"}, exclude_none=True, exclude_defaults=True)
    for key in ("joints", "drives"):
        text[key] = text[key][:JOINTS]
    text["limits"] = {key: values[:JOINTS] for key, values in text["limits"].items()}
    text["name"] = NAME
    text["simulation"] = {"clock": "simulated"}
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{NAME}.yaml"
    file.write_text(yaml.safe_dump(text, sort_keys=False), encoding="utf-8")
    return load_profile(file)


def with_secret(profile: Profile, seed: int, hidden: Sequence[HiddenFriction]) -> Profile:
    """The profile as the simulator gets it: masses and friction of its own, and what is hidden."""
    options = {"dynamics": {"spread": SPREAD, "seed": seed}, "effects": [asdict(h) for h in hidden]}
    simulation = Simulation(clock="simulated", seed=seed, options=options)
    return profile.model_copy(update={"simulation": simulation})
