"""The virtual arm, with a joint that somebody has pushed before it wakes up."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import yaml

from backends.virtual.plant import plant
from pa10d.client import local_daemon
from pa10d.profile import find_profile

LIMIT = 4.450589593  # rad, of joint 7


def build(profile, at: Mapping[str, float]):
    """As a profile names it. at: rad, where joints (from 1) stand instead."""
    arm = plant.build(profile)
    reset = arm.reset

    def pushed(q0):
        q0 = np.array(q0, dtype=float)
        for joint, position in at.items():
            q0[int(joint) - 1] = position
        reset(q0)

    arm.reset = pushed
    return arm


@pytest.fixture
def pushed(tmp_path, monkeypatch):
    """pushed(q): a daemon whose arm has its last joint at q rad."""

    def start(position: float):
        monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
        profile = yaml.safe_load(find_profile("pa10-sim").read_text())
        profile["urdf"] = str(find_profile("pa10-sim").with_name(profile["urdf"]))
        profile["simulation"] = {"plant": "pushed_arm:build", "options": {"at": {7: position}}}
        path = tmp_path / "pushed.yaml"
        path.write_text(yaml.safe_dump(profile))
        return local_daemon(tmp_path / "data", profile=str(path), clock="simulated")

    return start
