"""A stray arm on the page: where it stands, and a way back inside that asks once more."""

from __future__ import annotations

import json

import pytest
from browsers import until
from pushed_arm import LIMIT, pushed

__all__ = ["pushed"]
BUTTON = "Bring it back inside …"


@pytest.mark.long
def test_it_is_brought_back_where_that_is_confirmed(pushed, visit):
    with pushed(LIMIT + 0.05) as client:
        page = visit(client.url).page
        page.goto(f"{client.url}/#/robot")
        page.get_by_text("joint 7 stands 0.0500 rad beyond its upper limit").first.wait_for()
        page.get_by_role("button", name=BUTTON).click()
        page.get_by_role("button", name="Leave it").click()
        assert client.robot()["state"] == "inactive"
        page.get_by_role("button", name=BUTTON).click()
        page.get_by_role("button", name="Move it inside").click()
        page.get_by_text("The arm is back inside its limits.").wait_for()
        robot = client.robot()
        assert (robot["state"], robot["outside"]) == ("holding", [])
        until(page, "document.querySelector('#robot .doubt').hidden")


@pytest.mark.long
def test_too_far_out_the_page_offers_no_power(pushed, visit):
    with pushed(LIMIT + 0.3) as client:
        page = visit(client.url).page
        page.goto(f"{client.url}/#/robot")
        page.get_by_text("too far to be powered there").wait_for()
        assert not page.get_by_role("button", name=BUTTON).is_visible()


TOLD = """(robot) => {
  const { change } = globalThis.pa10dModules.get("base/store.js");
  change({ robot });
  const box = document.querySelector("#robot .doubt");
  return [box.hidden, box.textContent, box.querySelector("button").hidden];
}"""


def test_whoever_is_told_that_it_is_too_far_out_is_offered_no_power(archive, visit):
    visitor = visit(archive[0])
    visitor.open("robot")
    robot = json.loads(visitor.page.request.get(f"{archive[0]}/api/v1/robot").text())
    for far in (False, True):
        stray = {"joint": 7, "sentence": "joint 7 stands far out", "too_far": far}
        told = {**robot, "state": "inactive", "outside": [stray]}
        hidden, words, offers_none = visitor.page.evaluate(TOLD, told)
        assert not hidden
        assert ("too far to be powered there" in words) is far
        assert offers_none is far
