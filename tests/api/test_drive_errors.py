"""The error memory of the virtual drives, through daemon, control process and bus."""

from __future__ import annotations

import pytest

from pa10d.client import ApiError


def test_every_drive_is_asked_while_the_arm_is_unpowered(arm):
    arm.wait_for_robot("inactive")
    found = arm.drive_errors()
    assert [one["joint"] for one in found] == list(range(1, 8))
    assert all(one["history"] == [] and one["register"] == 0 for one in found)
    assert arm.drive_errors(clear=True) == found
    arm.enable()
    try:
        with pytest.raises(ApiError, match="needed: offline or inactive or fault") as refused:
            arm.drive_errors()
        assert refused.value.status == 409
    finally:
        arm.disable()
    arm.disconnect()
    try:
        assert arm.drive_errors() == found, "a bus that is not open is visited"
    finally:
        arm.connect()
    arm.wait_for_robot("inactive")
    arm.let_others_command()
