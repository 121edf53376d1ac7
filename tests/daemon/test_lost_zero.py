"""A drive that was off meanwhile and reads elsewhere: over HTTP and CAN."""

from __future__ import annotations

import pytest
from lost_zero import CHANNEL, turn

from pa10d.client import ApiError, local_daemon


def refusal(do, *arguments) -> str:
    with pytest.raises(ApiError) as refused:
        do(*arguments)
    assert refused.value.status == 409
    return str(refused.value)


@pytest.mark.long  # the page's test of the same sees it, too
def test_nothing_moves_before_somebody_has_looked(tmp_path):
    with local_daemon(tmp_path, clock="simulated", channel=CHANNEL) as client:
        client.wait_for_robot("inactive")
        assert client.confirm()["misplaced"] == [], "nothing to look for"
        client.disconnect()
        turn(3, 0.5)
        client.connect()
        client.wait_for_robot("inactive")
        (beside,) = client.robot()["misplaced"]
        assert abs(abs(beside["reads"] - beside["was"]) - 0.5) < 0.01
        assert beside["joint"] == 3
        assert "joint 3 stood at" in refusal(client.enable)
        assert "confirm" in refusal(client.experiment, "tracking")
        assert client.robot()["state"] == "inactive"
        assert client.confirm()["misplaced"] == []
        assert client.enable()["state"] == "holding"
        assert "disable" in refusal(client.confirm)
        client.disable()
