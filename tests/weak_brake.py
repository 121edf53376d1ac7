"""Shoulder and elbow of the virtual arm on a wall; the shoulder's brake holds half of its load."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from small_arm import joints_of_the_arm

from backends.virtual.plant import plant
from pa10d.client import local_daemon

HOLDS = 35.0  # N·m
SAYS = "the brake of joint 2 does not hold its load: it went 0.0"


def build(profile):
    """As a profile names it."""
    arm = plant.build(profile)
    arm.brakes = np.array([500.0, HOLDS, 200.0])
    return arm


@pytest.fixture
def weak_brake(tmp_path, monkeypatch):
    """A daemon with that arm."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    profile = joints_of_the_arm()
    profile["base"] = {"rpy": [0.0, 1.5707963, 0.0]}
    profile["environment"] = {"floor": "none"}
    profile["simulation"] = {"plant": "weak_brake:build"}
    path = tmp_path / "weak.yaml"
    path.write_text(yaml.safe_dump(profile))
    with local_daemon(tmp_path / "data", profile=str(path), clock="simulated") as client:
        client.wait_for_robot("inactive")
        yield client
