"""Known weights by buttons: planned, recorded without and with, gains written and taken back."""

from __future__ import annotations

import pytest

from pa10d.client import local_daemon
from pa10d.profile.load import find_profile

pytestmark = [pytest.mark.timeout(900), pytest.mark.long]


@pytest.fixture
def weak(browser, tmp_path):
    """A virtual UR5e of one's own whose motors are not what their nameplates say."""
    source = find_profile("ur5e")
    path = tmp_path / "mine.yaml"
    text = source.read_text().replace("urdf: ur5e.urdf", f"urdf: {source.parent}/ur5e.urdf")
    path.write_text(text + "  options: {torque_gains: [1.0, 1.12, 0.9, 1.08, 0.93, 1.1]}\n")
    with local_daemon(tmp_path / "data", str(path), clock="simulated") as client:
        yield client, path


def test_a_weighing_by_buttons(weak, visit):
    client, path = weak
    before = path.read_text()
    visitor = visit(client.url)
    page = visitor.page
    visitor.open()
    page.goto(f"{client.url}/#/experiments")
    panel = page.locator("#weighing")
    page.locator("#weigh-begin").click()
    panel.get_by_text("Take every load off").wait_for(timeout=60_000)
    for told in ("would be known to", "Torque gains"):
        page.locator("#weigh-record:enabled").click(timeout=60_000)
        page.get_by_role("dialog").get_by_role("button", name="Record").click()
        panel.get_by_text(told).first.wait_for(timeout=300_000)
    assert panel.locator("li.done").count() == 2
    row = panel.locator("tr", has_text="shoulder_lift_joint").first.inner_text()
    assert "1.1" in row
    page.locator("#weigh-apply:enabled").click(timeout=60_000)
    page.get_by_role("dialog").get_by_role("button", name="Write").click()
    page.locator("#weigh-undo").wait_for(timeout=60_000)
    assert path.read_text().count("torque_gain:") >= 5
    client.wait_for_robot("inactive", timeout=60)  # control has started anew with it
    page.locator("#weigh-undo:enabled").click(timeout=60_000)
    page.locator("#weigh-apply").wait_for(timeout=60_000)
    assert path.read_text() == before
    assert not visitor.errors
