"""The whole weighing on the virtual arm, in simulated time: through drives, bus and loop."""

from __future__ import annotations

import pytest

from pa10d.client import local_daemon
from pa10d.profile.load import find_profile

pytestmark = [pytest.mark.alone, pytest.mark.long, pytest.mark.timeout(900)]
TRUE = [1.0, 1.12, 0.9, 1.08, 0.93, 1.1]


def test_wrong_torque_constants_are_weighed_applied_and_taken_back(tmp_path):
    source = find_profile("ur5e")
    text = source.read_text().replace("urdf: ur5e.urdf", f"urdf: {source.parent}/ur5e.urdf")
    options = f"  options: {{torque_gains: {TRUE}, dynamics: {{spread: 0.1}}}}\n"
    path = tmp_path / "mine.yaml"
    path.write_text(text + options)
    weight = "3+-0.006,0.05+-0.001,0+-0.001,0.1+-0.001"
    with local_daemon(tmp_path / "data", str(path), clock="simulated") as arm:
        begun = arm.begin_weighing([weight], "w")
        assert begun["next"]["weight"] == 0
        first = arm.weigh("w", 0)
        assert first["next"]["weight"] == 1
        second = arm.weigh("w", 1)
        for line, true in list(zip(second["joints"], TRUE, strict=True))[1:]:
            assert abs(line["gain"] - true) < 4 * line["std_error"]
            assert line["std_error"] < 0.05
        applied = arm.apply_weighing("w")
        arm.wait_for_robot("inactive", timeout=60)
        assert set(applied["applied"]["gains"]) >= {"2", "3", "4", "5", "6"}

        arm.begin_weighing([weight], "again")  # under the profile that was put right
        arm.weigh("again", 0)
        right = arm.weigh("again", 1)
        for line in right["joints"][1:]:
            assert abs(line["gain"] - 1.0) < 0.06
        before = path.read_text()
        arm.undo_weighing("w")
        assert path.read_text() != before
        assert path.read_text() == text + options
