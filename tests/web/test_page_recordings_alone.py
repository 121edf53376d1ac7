"""An investigation of recordings: without any to fit to nothing is planned, least of all motion."""

from __future__ import annotations

import pytest


def test_without_recordings_there_is_nothing_to_plan(archive, visit):
    visitor = visit(archive[0])
    page = visitor.page
    visitor.open("investigate")
    page.get_by_label("From").select_option("runs")
    plan = page.get_by_role("button", name="Show what will be done")
    assert plan.is_enabled(), "what is marked to fit to is chosen"
    page.locator("#investigate summary", has_text="Fit to").click()
    page.locator("#investigate").get_by_label("train_a").first.uncheck()
    assert plan.is_disabled()
    assert page.get_by_text("Choose the recordings to fit to.").is_visible()
    page.locator("#investigate").get_by_label("train_a").first.check()
    assert plan.is_enabled()
    assert not page.get_by_text("Choose the recordings to fit to.").count()
    page.locator("#investigate").get_by_label("train_a").first.uncheck()
    page.get_by_label("From").select_option("arm")
    assert plan.is_enabled()
    assert not visitor.errors


@pytest.mark.parametrize(
    "asked", [{"fit": [], "validate": []}, {"validate": ["valid_a"]}, {"fit": []}]
)
def test_who_speaks_of_recordings_moves_no_arm(archive, visit, asked):
    page = visit(archive[0]).page
    answer = page.request.post(f"{archive[0]}/api/v1/investigations", data=asked)
    assert answer.status == 400
    assert "fit: found no runs, expected those to fit a model to" in answer.json()["detail"]
