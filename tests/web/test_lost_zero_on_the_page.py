"""A joint that reads elsewhere than it stood, on the page: somebody looks, and says so."""

from __future__ import annotations

import pytest
from lost_zero import CHANNEL, turn
from small_arm import small_arm

from pa10d.client import local_daemon

BUTTON = "I have looked …"


@pytest.mark.long
def test_nothing_moves_before_somebody_has_looked(tmp_path, visit):
    path = str(small_arm(tmp_path))
    with local_daemon(tmp_path / "data", path, clock="simulated", channel=CHANNEL) as client:
        client.wait_for_robot("inactive")
        client.disconnect()
        turn(4, 0.5)  # the node of the third joint
        client.connect()
        client.wait_for_robot("inactive")
        client.let_others_command()
        page = visit(client.url).page
        page.goto(f"{client.url}/#/robot")
        page.get_by_text("not powered before somebody has looked at it: joint 3 stood").wait_for()
        assert page.get_by_role("button", name="Enable").is_disabled()
        page.get_by_role("button", name=BUTTON).click()
        page.get_by_role("button", name="Leave it").click()
        assert client.robot()["misplaced"]
        page.get_by_role("button", name=BUTTON).click()
        page.get_by_role("button", name="It stands as drawn").click()
        page.get_by_text("The arm is taken to stand where it reads.").wait_for()
        assert client.robot()["misplaced"] == []
        page.get_by_role("button", name=BUTTON).wait_for(state="hidden")
        page.get_by_text("Next step Nothing is recorded yet").wait_for()
        assert page.get_by_role("button", name="Enable").is_enabled()
