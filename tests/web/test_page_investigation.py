"""The whole investigation by one button: what will be done is shown, then done, then reported."""

from __future__ import annotations

import os
import re
import signal

import pytest
from benches import children_of, served_arm
from small_arm import small_arm

from pa10d.client import running_at
from pa10d.daemon.presence import present

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


def test_after_a_fault_and_after_a_restart_it_goes_on(tmp_path, browser, visit):
    data, options = tmp_path / "data", ["--profile", str(small_arm(tmp_path))]
    channel = f"again-{tmp_path.name[-20:]}"
    with served_arm(data, channel, *options) as url, running_at(url, data) as client:
        client.wait_for_robot("inactive", timeout=120)
        visitor = visit(url)
        page = visitor.page
        visitor.open("investigate")
        page.get_by_label("Minutes of motion, at most").fill("4")
        page.get_by_role("button", name="Show what will be done").click()
        panel = page.locator("#investigation")
        panel.get_by_text("Nothing has moved yet").wait_for(timeout=240_000)
        panel.get_by_role("button", name="Start").click()
        page.get_by_role("dialog").get_by_role("button", name="Start").click()
        panel.locator("li.running", has_text="Excitation").wait_for(timeout=400_000)
        for pid in children_of(present(data).pid, "pa10d.daemon.processes.simulator"):
            os.kill(pid, signal.SIGKILL)
        panel.get_by_text("It could not go on").wait_for(timeout=120_000)
        assert panel.get_by_role("button", name="Go on").is_disabled()
        page.locator("#investigate .guide a", has_text="Reset").click()
        page.locator("#robot").get_by_role("button", name="Reset").click()
        page.locator("#arm-state", has_text="inactive").wait_for(timeout=120_000)
        page.get_by_role("link", name="Investigate").first.click()
        recorded = [run["id"] for run in client.runs() if run["status"] == "success"]
        assert recorded, "what was recorded before stays"
        panel.get_by_role("button", name="Go on").click()
        panel.locator("li.running", has_text="Fit the textbook model").wait_for(timeout=400_000)
        assert not visitor.errors
    with served_arm(data, channel, *options) as url, running_at(url, data) as client:
        client.wait_for_robot("inactive", timeout=120)
        before = len(client.runs())
        visitor = visit(url)
        page = visitor.page
        visitor.open("robot")
        page.locator("#robot .guide a", has_text="Go on").click()
        panel = page.locator("#investigation")
        panel.get_by_text("It was stopped").wait_for()
        panel.get_by_role("button", name="Go on").click()
        panel.get_by_role("link", name="Open the report").wait_for(timeout=800_000)
        assert "Stribeck friction in joint 3" in panel.locator(".verdict").inner_text()
        after = client.runs()
        assert set(recorded) <= {run["id"] for run in after}
        assert len(after) - before <= 1, "only the fresh motion was still to be made"
        assert not visitor.errors
