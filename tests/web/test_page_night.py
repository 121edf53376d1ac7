"""The whole story of an arm to which something happens over night, by the page's own buttons.

Every change that 'serve --hide any' can draw is found again on the page, and told in the end.
"""

from __future__ import annotations

import re

import pytest
from benches import served_arm
from small_arm import small_arm

from backends.virtual.plant.catalogue import LISTED
from pa10d.client import running_at
from pa10d.effects import all_effects

SHOWN = [name for name in LISTED if not all_effects()[name].escapes_demo]
CHANGES = sorted(name for name in SHOWN if all_effects()[name].question == "changed")
PATIENCE = 900_000  # ms on a loaded machine
SEED = 11


def test_what_is_walked_here_is_all_that_a_night_can_bring():
    assert CHANGES == ["base_tilt", "encoder_offset", "payload", "torque_gain"]


def investigate(page, about: str) -> str:
    """Ask, start, wait for the report: what was found, in words."""
    page.locator("#question").select_option(label=about)
    page.get_by_role("button", name="Show what will be done").click()
    panel = page.locator("#investigation")
    panel.get_by_text("Nothing has moved yet").wait_for(timeout=PATIENCE)
    panel.get_by_role("button", name="Start").click()
    page.get_by_role("dialog").get_by_role("button", name="Start").click()
    panel.get_by_text("Nothing has moved yet").wait_for(state="detached")
    panel.get_by_role("link", name="Open the report").wait_for(timeout=PATIENCE)
    return panel.locator(".verdict").inner_text()


def newest(client) -> dict:
    """The last investigation as JSON."""
    found = client._ask("GET", "/api/v1/investigations")["items"][0]["id"]
    return client._ask("GET", f"/api/v1/investigations/{found}")


@pytest.mark.long
@pytest.mark.timeout(2000)
@pytest.mark.parametrize("effect", CHANGES)
def test_what_a_night_brings_is_found_and_told(tmp_path, browser, visit, effect):
    hiding = ["--profile", str(small_arm(tmp_path)), "--hide", effect, "--seed", str(SEED)]
    data = tmp_path / "data"
    with (
        served_arm(data, f"night-{tmp_path.name[-20:]}", *hiding) as url,
        running_at(url, data) as client,
    ):
        client.wait_for_robot("inactive", timeout=120)
        visitor = visit(url)
        page = visitor.page
        visitor.open("investigate")
        first = investigate(page, "what is missing in its model?")
        assert newest(client)["verdict"] == "none"
        assert "nothing" in first.lower()

        page.get_by_role("button", name="Let a night pass").click()
        page.locator("#story", has_text="day 2").wait_for(timeout=120_000)
        page.locator("#arm-state", has_text="inactive").wait_for(timeout=120_000)
        investigate(page, "what has changed since investigation-m0?")
        whole = newest(client)
        assert [one["effect"] for one in whole["findings"]] == [effect]
        before, after = (whole["judged"][side] for side in ("before", "after"))
        worst = max(range(3), key=lambda j: before[j] / after[j])
        print(f"{effect}: {before[worst]:.3g} -> {after[worst]:.3g} N·m at joint {worst + 1}")
        assert after[worst] < 0.5 * before[worst]

        page.get_by_role("button", name="Reveal what it hides").click()
        page.get_by_role("dialog").get_by_role("button", name="Reveal").click()
        told = page.locator("#story .verdict")
        told.wait_for()
        assert re.match(rf"It hides: {effect}.*, since the night\.$", told.inner_text())
        assert not visitor.errors
