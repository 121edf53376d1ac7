"""The user's whole sentence, clicked: record, fit, compare, diagnose, add, the error falls."""

from __future__ import annotations

import re

import pytest
from browsers import until
from small_arm import HIDDEN

FOLLOWED = 240_000  # ms for what takes long on a loaded machine
SLOW = {"fundamental": 0.05, "harmonics": 3, "cycles": 1}
SHORT = [
    {"kind": "excitation", "parameters": {**SLOW, "seed": 2}, "tags": ["fit"], "why": "To fit."},
    {
        "kind": "excitation",
        "parameters": {**SLOW, "seed": 9},
        "tags": ["judge"],
        "why": "To judge.",
    },
]
"""A starting set that shows what this arm hides in 40 s; its joints are taken as the URDF says."""


def follow_the_guide(page, label: str) -> None:
    """Press what the page says is the next step: nothing else is known to a stranger."""
    link = page.locator("section:visible .guide a", has_text=re.compile(f"^{label}$"))
    link.wait_for(timeout=FOLLOWED)
    link.click()


def shortened(route) -> None:
    """The daemon's own answer, with the short set in it."""
    if route.request.method != "GET":
        route.continue_()
        return
    answer = route.fetch()
    route.fulfill(response=answer, json={**answer.json(), "starting_set": SHORT})


@pytest.mark.timeout(600)
@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.long)])
def test_a_stranger_gets_from_an_empty_page_to_a_lower_error(arm, visit, whole):
    """The whole set, five motions, with --long."""
    for run in arm.runs():  # of other tests
        arm.delete_run(run["id"])
    visitor = visit(arm.url)
    page = visitor.page
    if not whole:
        page.route("**/api/v1/experiments", shortened)
    visitor.open()

    follow_the_guide(page, "Record")
    page.get_by_role("button", name="Record the starting set").click()
    page.locator("#arm-state", has_text="running").wait_for(timeout=FOLLOWED)
    page.reload()  # the daemon keeps the work, the page finds it again
    page.locator("#jobs progress").wait_for()
    assert "Experiments" in page.locator("#jobs").inner_text()

    page.goto(f"{arm.url}/#/runs")
    page.locator("#runs tbody tr").nth(3 if whole else 1).wait_for(timeout=FOLLOWED)
    follow_the_guide(page, "Fit")
    page.click("#fit-start")
    page.locator("#models [data-model=m0]").wait_for(timeout=FOLLOWED)

    follow_the_guide(page, "Compare")
    page.click("#compare-start")
    page.locator("#compare .beside .canvas .main-svg").first.wait_for()
    sentence = page.locator(".sentence").first
    sentence.wait_for(timeout=FOLLOWED)
    sentence.click()
    until(
        page,
        "document.querySelector('#compare .beside .canvas').layout.xaxis.range[1]"
        " - document.querySelector('#compare .beside .canvas').layout.xaxis.range[0] < 20",
    )

    follow_the_guide(page, "Diagnose")
    page.click("#diagnose-start")
    page.locator("#jobs", has_text="Diagnosis").wait_for()
    page.reload()
    card = page.locator(".finding").first
    card.wait_for(timeout=FOLLOWED)
    assert card.get_attribute("data-effect") == HIDDEN["effect"]
    assert f"joint {HIDDEN['joint']}" in card.locator("h2").inner_text()
    assert "How to read this" in card.inner_text()
    card.locator(".canvas .main-svg").first.wait_for()

    card.get_by_role("button", name="Add to model").click()
    added = card.get_by_role("link", name=re.compile("Added as m1"))
    added.wait_for(timeout=FOLLOWED)
    assert page.locator("#asked", has_text="Asked of m0").count() == 1  # m1 is chosen by now
    added.click()
    page.locator(".stairs .canvas .main-svg").first.wait_for(timeout=FOLLOWED)
    stairs = page.evaluate(
        "[...document.querySelector('.stairs .canvas').data].map((one) => Array.from(one.y))"
    )
    before, after = stairs[HIDDEN["joint"] - 1]
    assert after < 0.5 * before, stairs
    assert f"joint {HIDDEN['joint']} fell" in page.locator(".stairs").inner_text()

    page.get_by_role("button", name="Load into the controller").click()
    page.get_by_role("button", name="Loaded in the controller").wait_for()
    assert arm.robot()["model"] == "m1"
    assert not visitor.errors
    assert not visitor.foreign()
