"""The whole investigation by one button: what will be done is shown, then done, then reported."""

from __future__ import annotations

import re

import pytest

pytestmark = [pytest.mark.timeout(900), pytest.mark.long]


def test_an_investigation_by_buttons(arm, visit):
    visitor = visit(arm.url)
    page = visitor.page
    visitor.open()
    page.locator("section:visible .guide a", has_text=re.compile("^Investigate$")).click()
    page.get_by_role("button", name="Show what will be done").click()
    panel = page.locator("#investigation")
    panel.get_by_text("Nothing has moved yet").wait_for(timeout=240_000)
    assert panel.locator(".courses svg").count() >= 5, "a preview of each motion"
    assert arm.robot()["state"] == "inactive"
    assert not arm.runs(), "nothing was recorded before somebody said so"

    panel.get_by_role("button", name="Start").click()
    page.get_by_role("dialog").get_by_role("button", name="Start").click()
    panel.locator("li.running").wait_for()
    panel.get_by_role("button", name="Pause after this step").click()
    panel.get_by_text("It rests").wait_for(timeout=400_000)
    recorded = len(arm.runs())
    assert recorded >= 1

    panel.get_by_role("button", name="Go on").click()
    panel.locator("li.running", has_text="Excitation").wait_for(timeout=60_000)
    panel.get_by_role("button", name="Stop", exact=True).click()
    panel.get_by_text("It was stopped").wait_for(timeout=60_000)
    assert arm.robot()["state"] in ("holding", "inactive", "stopping", "disabling")

    arm.wait_for_robot("inactive", "holding")
    panel.get_by_role("button", name="Go on").click()
    panel.get_by_role("link", name="Open the report").wait_for(timeout=800_000)
    assert "Stribeck friction in joint 3" in panel.locator(".verdict").inner_text()
    address = panel.get_by_role("link", name="Open the report").get_attribute("href")
    assert page.request.get(f"{arm.url}/{address}").ok
    assert not visitor.errors
