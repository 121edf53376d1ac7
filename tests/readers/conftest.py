"""The arm whose recordings are read."""

from __future__ import annotations

import pytest
from test_formats import URDF

from pa10d.services.robots import load_robot


@pytest.fixture
def robot(tmp_path):
    """(profile, robot) of a bare URDF."""
    (tmp_path / "robot.urdf").write_text(URDF)
    return load_robot(tmp_path / "robot.urdf")
