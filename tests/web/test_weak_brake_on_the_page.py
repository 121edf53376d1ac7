"""A brake that does not hold, on the page: power stays, and goes where that is asked once more."""

from __future__ import annotations

import json

import pytest
from weak_brake import SAYS, weak_brake

__all__ = ["weak_brake"]
BUTTON = "Disable anyway …"

TOLD = """(robot) => {
  const { change } = globalThis.pa10dModules.get("base/store.js");
  change({ robot, connected: true, heard: performance.now() });
  const box = [...document.querySelectorAll("#robot .doubt")].at(-1);
  const guide = document.querySelector("section:not([hidden]) .guide");
  return [box.hidden, box.textContent, guide.textContent];
}"""


def test_it_is_said_while_power_stays_and_no_longer(archive, visit):
    visitor = visit(archive[0])
    visitor.open("robot")
    robot = json.loads(visitor.page.request.get(f"{archive[0]}/api/v1/robot").text())
    weak = {"joint": 2, "gone": 0.0056, "unit": "rad", "sentence": f"{SAYS}056 rad"}
    for state, found, hides in (("holding", [], True), ("holding", [weak], False),
                                ("inactive", [], True)):  # fmt: skip
        told = {**robot, "quiet": 0.0, "offline_passes": False, "state": state, "unheld": found}
        hidden, words, guide = visitor.page.evaluate(TOLD, told)
        assert hidden is hides
        assert ("Support the arm, then disable it." in words) is not hidden or not found
        assert (f"The{SAYS[3:]}" in guide) is not hides, "it comes before the story"


@pytest.mark.long
def test_power_goes_where_that_is_confirmed(weak_brake, visit):
    client = weak_brake
    client.enable()
    client.let_others_command()
    page = visit(client.url).page
    page.goto(f"{client.url}/#/robot")
    page.get_by_role("button", name="Disable", exact=True).click()
    page.locator("#robot .doubt", has_text=SAYS).wait_for()
    assert not page.get_by_text("The arm could not be disabled.").count(), "the panel says so"
    page.get_by_role("button", name=BUTTON).click()
    page.get_by_role("button", name="Leave it").click()
    assert client.robot()["state"] == "holding"
    page.get_by_role("button", name=BUTTON).click()
    page.get_by_role("button", name="Take the power away").click()
    client.wait_for_robot("inactive", "fault")
