"""Commands in the browser: cancel, stop, forms, and two people at once."""

from __future__ import annotations

import re

import pytest
from browsers import until

LONG = 120_000  # ms for planning and checking on a loaded machine


@pytest.fixture(autouse=True)
def at_rest(arm):
    yield
    for job in arm._ask("GET", "/api/v1/jobs", params={"status": "running"})["items"]:
        arm.cancel(job["id"])
    arm.wait_for_robot("inactive")
    while (holder := arm.robot()["lease"]["holder"]) is not None:
        arm._http.delete("/api/v1/robot/lease", headers={"X-Client": holder})


def start_moving(page) -> None:
    page.click("[data-kind=tracking]")
    page.get_by_label("cycles").fill("25")
    page.get_by_role("button", name="Start", exact=True).click()
    page.locator("#arm-state", has_text="running").wait_for(timeout=LONG)


def last_job(arm) -> dict:
    return arm._ask("GET", "/api/v1/jobs", params={"kind": "experiment"})["items"][0]


def test_abort_ends_an_experiment(arm, visit):
    visitor = visit(arm.url)
    visitor.open("experiments")
    start_moving(visitor.page)
    visitor.page.locator("#jobs").get_by_role("button", name="Abort").click()
    visitor.page.locator("#jobs", has_text="Experiment cancelled").wait_for()
    visitor.page.locator("#arm-state", has_text="inactive").wait_for(timeout=LONG)
    assert arm._ask("GET", "/api/v1/jobs", params={"kind": "experiment"})["items"][0]["status"] == (
        "cancelled"
    )


@pytest.mark.parametrize("how", [pytest.param("button", marks=pytest.mark.long), "key"])
def test_stop_while_moving(arm, visit, how):
    visitor = visit(arm.url)
    visitor.open("experiments")
    start_moving(visitor.page)
    visitor.page.goto(f"{arm.url}/#/runs")
    if how == "button":
        visitor.page.click("#stop")
    else:
        visitor.page.keyboard.press("Escape")
        visitor.page.keyboard.press("Escape")
    visitor.page.locator("#arm-state", has_text="inactive").wait_for(timeout=LONG)
    assert arm.robot()["state"] == "inactive"
    assert "stop" in last_job(arm)["error"]


@pytest.mark.long
def test_the_second_browser_may_look_and_stop_but_not_command(arm, visit):
    first, second = visit(arm.url), visit(arm.url)
    first.open("experiments")
    second.open("robot")
    start_moving(first.page)
    page = second.page
    page.locator("#lease", has_text="commands").wait_for()
    page.locator("#arm-state", has_text="running").wait_for()
    assert page.get_by_role("button", name="Disable").is_disabled()
    page.goto(f"{arm.url}/#/experiments")
    assert page.get_by_role("button", name="Record the starting set").is_disabled()
    refused = page.evaluate(
        "fetch('/api/v1/robot/disable', {method: 'POST', headers: {'X-Client': 'second'}})"
        ".then((answer) => answer.json())"
    )
    assert (refused["status"], refused["type"]) == (409, "/api/v1/problems/held")
    page.click("#stop")
    first.page.locator("#arm-state", has_text="inactive").wait_for(timeout=LONG)
    assert first.page.locator("#lease").inner_text() == "you command"
    first.page.click("#lease")
    page.locator("#lease", has_text="free to command").wait_for()


def test_a_motion_is_checked_before_it_starts(arm, visit):
    visitor = visit(arm.url)
    page = visitor.page
    visitor.open("experiments")
    page.click("[data-kind=tracking]")
    page.get_by_label("amplitude").fill("3")
    page.get_by_role("button", name="Check").click()
    page.locator(".checks .bad").first.wait_for(timeout=LONG)
    page.get_by_label("amplitude").fill("0.2")
    page.get_by_role("button", name="Check").click()
    page.locator(".checks .good", has_text="Go.").wait_for(timeout=LONG)
    page.get_by_label("period").fill("")
    page.get_by_role("button", name="Start", exact=True).click()
    assert page.locator("input:invalid").count() == 1
    assert arm.robot()["state"] == "inactive"


@pytest.mark.long
def test_live_values_survive_a_refresh(arm, visit):
    visitor = visit(arm.url)
    page = visitor.page
    visitor.open("experiments")
    start_moving(page)
    page.goto(f"{arm.url}/#/robot")
    page.reload()
    page.locator("#arm-state", has_text="running").wait_for()
    drawn = "[...document.querySelectorAll('.scope canvas')].map((c) => c.toDataURL().length)"
    until(page, f"{drawn}.length === 4")
    until(page, f"Math.min(...{drawn}) > 4000")
    speeds = page.locator(".axes tbody td:nth-child(4)").all_inner_texts()
    assert len(speeds) == 3
    assert all(re.fullmatch(r"-?\d+\.\d{3}", text) for text in speeds)
